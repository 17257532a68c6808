#pragma once

#include <nlohmann/json.hpp>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/alignment/session_clocks.hpp"
#include "tactile/alignment/video_clock.hpp"
#include "tactile/labels/onset.hpp"
#include "tactile/labels/posterior/posterior_labels.hpp"
#include "tactile/labels/touch_end.hpp"
#include "tactile/labels/touches.hpp"

namespace tactile::labels {

/// How labels are found: stage by stage, or all at once by a model of the run.
enum class LabelMethod { stages, model };

struct LabelOptions {
  LabelMethod method = LabelMethod::stages;
  DoubtLimits doubt{};  ///< of the model
  alignment::RunSignalsOptions signals{};
  alignment::RobotClocksOptions clocks{};
  TouchesOptions touches{};
  OnsetOptions onset{};
  EndOptions end{};
  alignment::VideoClockOptions video_clock{};
  microseconds longest_disagreement{100'000};  ///< flagged if slip and lift differ by more in length, or film and events in
                                               ///< an onset
  microseconds latest_slip{250'000};           ///< flagged if the slip starts this long after the lift
  microseconds earliest_slip{5'000};           ///< flagged if it starts this long before, minus the clock's uncertainty
};

nlohmann::json settings_of(const LabelOptions& options);

/// How the robot log was read that these labels were made from: by the settings in their provenance.
robot::RobotLogOptions robot_log_options_of(const nlohmann::json& provenance);

/// The same of all signals: region of the film, mask of pixels, columns of the robot log. What the provenance lacks is as by
/// default.
alignment::RunSignalsOptions signals_options_of(const nlohmann::json& provenance);

}  // namespace tactile::labels
