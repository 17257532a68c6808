#pragma once

#include <nlohmann/json.hpp>

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/activity.hpp"
#include "tactile/labels/event_rate.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/onset.hpp"

namespace tactile {

struct LabelOptions {
  EventRateOptions rate{};
  ActivityOptions activity{};
  OnsetOptions onset{};
  microseconds press_ends{20'000};  ///< a press ends at the first so long quiet
  microseconds slip_ends{150'000};  ///< a slip likewise: stick phases belong to it
  double ambiguous_below = 1.2;     ///< flagged if the best match of a burst with the lift is not so much better than the second
  microseconds longest_lag{
      250'000};  ///< flagged if the robot's lift start and the slip onset lie further apart once the clocks are aligned
};

nlohmann::json settings_of(const LabelOptions& options);

/// Finds press and slip in a run from its events and robot log, and relates the robot's clock to the camera's:
///
/// 1. Bursts of the event rate, hot pixels left out.
/// 2. The robot's lift: the motion phase that rises most. Each burst in turn is laid over it and compared with its speed; the
/// best match is
///    the slip. (Event rate follows |velocity|.)
/// 3. The clock's offset is the mean of burst start - lift start and burst end - lift end. Shear delays what the camera sees of
/// the start, and
///    brings forward what it sees of the end, so that the two errors oppose each other; half their difference is the residual.
///    Drift is not measurable in one run and taken as 0.
/// 4. Onsets by maximum likelihood on the events alone (`onset_near`), so that no error of the clocks enters them; ends at the
/// first quiet.
///    Bursts before the slip are presses; those behind it are after-effects and stay unlabelled.
///
/// Reads the events, the robot log and run.json, nothing else. A run without robot log is labelled by order alone, and flagged.
/// @throws Error  if the events or the robot log cannot be read
/// Source: Faris et al., arXiv:2403.10120, section IV.
Labels label_run(const RunFolder& run, const LabelOptions& options = {});

}  // namespace tactile
