#pragma once

#include <optional>
#include <vector>

#include "tactile/alignment/fitted_clock.hpp"
#include "tactile/alignment/run_signals.hpp"
#include "tactile/core/touch.hpp"

namespace tactile::labels {

/// A touch that may have happened.
struct LikelyTouch {
  Touch touch = Touch::none;
  double probability = 0;               ///< that it did, and is of this class
  alignment::UncertainTime start, end;  ///< medians and 95 % intervals, if it did
};

/// An offset of a clock, the camera's time less the other one's [us].
struct LikelyOffset {
  std::int64_t median_us = 0, low_us = 0, high_us = 0;
  RobotTime first_stamp{};  ///< of the piece of the log
};

/// What is known about a run from its signals.
struct RunPosterior {
  std::vector<LikelyTouch> touches;     ///< those with a probability of at least 0.05, by start
  std::vector<TouchInterval> releases;  ///< more likely than not, by start
  std::optional<LikelyOffset> robot;    ///< of the longest piece of the log
};

/// Draws from the posterior of a hidden Markov chain of what happens (`RunStates`), given the events and, for each possible
/// offset of its clock, the robot's log. @throws Error  if the recording cannot be read
RunPosterior run_posterior(const alignment::RunSignals& signals);

}  // namespace tactile::labels
