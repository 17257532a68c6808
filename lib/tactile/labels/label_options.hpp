#pragma once

#include <nlohmann/json.hpp>

#include "tactile/alignment/run_signals.hpp"

namespace tactile::labels {

/// What a person should look at.
struct DoubtLimits {
  double least_probability = 0.9;  ///< of a touch and its class, 0.5 to 1
  double widest_onset_ms = 100;    ///< 95 % interval of its onset, > 0
};

struct LabelOptions {
  DoubtLimits doubt{};
  alignment::RunSignalsOptions signals{};
};

nlohmann::json settings_of(const LabelOptions& options);

/// How the robot log was read that these labels were made from: by the settings in their provenance.
robot::RobotLogOptions robot_log_options_of(const nlohmann::json& provenance);

/// The same of all signals: region of the film, mask of pixels, columns of the robot log. What the provenance lacks is as by
/// default.
alignment::RunSignalsOptions signals_options_of(const nlohmann::json& provenance);

}  // namespace tactile::labels
