#pragma once

#include <nlohmann/json.hpp>

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/activity.hpp"
#include "tactile/labels/event_rate.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/onset.hpp"
#include "tactile/labels/touch_end.hpp"

namespace tactile {

struct LabelOptions {
  EventRateOptions rate{};
  ActivityOptions activity{};
  OnsetOptions onset{};
  EndOptions end{};
  double ambiguous_below = 1.2;  ///< flagged if the best match of a burst with the lift is not so much better than the second
  microseconds longest_disagreement{
      100'000};  ///< flagged if burst and lift differ by more than this in length, starts laid over each other
  microseconds shortest_gap{
      5'000};  ///< flagged if no pixel fires for so long, where the noise alone should have given 30 events at least
};

nlohmann::json settings_of(const LabelOptions& options);

/// Finds press and slip in a run from its events and robot log, and relates the robot's clock to the camera's:
///
/// 1. Bursts of the event rate, hot pixels left out.
/// 2. The robot's lift: the motion phase that rises most. Each burst in turn is laid over it and compared with its speed; the
/// best match is
///    the slip. (Event rate follows |velocity|.)
/// 3. The clock's offset is the mean of slip start - lift start and slip end - lift end. Slack delays the start by some ms and
/// ringing the end by
///    tens, so that the residual is taken as 10 ms at least: only anchors without such a bias make it smaller. Drift is not
///    measurable in one run and taken as 0.
/// 4. Onsets and ends on the events alone (`press_onset`, `slip_onset`, `press_end`, `slip_end`), so that no error of the clocks
///    enters them. Bursts before the slip are presses, but for what is too brief and too small, and for what undoes a press: that
///    is its release. Those behind it are after-effects and stay unlabelled.
///
/// Reads the events, the robot log and run.json, nothing else. What cannot be relied on is flagged: a damaged or unfinished
/// recording, one that lost events on their way, a gap in it or in the robot log, a robot's clock that starts anew, no robot log
/// (then labels go by order alone), a slip that does not fit the lift.
/// @throws Error  if the events or the robot log cannot be read
/// Source: Faris et al., arXiv:2403.10120, section IV.
Labels label_run(const RunFolder& run, const LabelOptions& options = {});

}  // namespace tactile
