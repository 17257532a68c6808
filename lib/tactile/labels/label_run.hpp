#pragma once

#include <nlohmann/json.hpp>

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/onset.hpp"
#include "tactile/labels/run_signals.hpp"
#include "tactile/labels/session_clocks.hpp"
#include "tactile/labels/touch_end.hpp"
#include "tactile/labels/touches.hpp"
#include "tactile/labels/video_clock.hpp"

namespace tactile {

struct LabelOptions {
  RunSignalsOptions signals{};
  RobotClocksOptions clocks{};
  TouchesOptions touches{};
  OnsetOptions onset{};
  EndOptions end{};
  VideoClockOptions video_clock{};
  microseconds longest_disagreement{100'000};  ///< flagged if slip and lift differ by more than this in length, or film and
                                               ///< events in an onset
  microseconds latest_slip{250'000};           ///< flagged if the slip starts so long after the lift
  microseconds earliest_slip{5'000};           ///< flagged if it starts so long before, the clock's uncertainty taken off
};

nlohmann::json settings_of(const LabelOptions& options);

/// Finds press and slip in what was read of a run, in camera time:
///
/// 1. Bursts of the event rate, hot pixels left out, are told apart (`kinds_of`) by the arm's lifts and taps, brought into camera
///    time, and by what they do to the picture. What is neither press nor slip stays unlabelled.
/// 2. Onsets and ends by maximum likelihood on the events alone, so that no error of the clocks enters them.
/// 3. Robot, film and inertial sensor are witnesses: what each says of an onset is its evidence.
///
/// What cannot be relied on is flagged, in words: problems of the files, a lift without slip, a press that nothing witnesses to
/// be missing, onsets that the events do not decide, sources that disagree, clocks that could not be related.
/// @param clocks  of this run, by `robot_clocks_of`
/// @throws Error  if the events cannot be read
/// Source: Faris et al., arXiv:2403.10120, section IV.
Labels label_signals(const RunSignals& signals, const RobotClocks& clocks, const LabelOptions& options = {});

/// Likewise of one run by itself: reads events, robot log, film and run.json, nothing else.
/// @throws Error  if events or robot log cannot be read
Labels label_run(const RunFolder& run, const LabelOptions& options = {});

}  // namespace tactile
