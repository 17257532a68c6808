#pragma once

#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/labels/posterior/likely_touches.hpp"

namespace tactile::labels {

/// An offset of a clock, the camera's time less the other one's [us].
struct LikelyOffset {
  std::int64_t median_us = 0, low_us = 0, high_us = 0;
  std::size_t piece = 0;                    ///< of the log
  std::optional<std::int64_t> imu_us = {};  ///< the likeliest by the IMU alone
};

/// A motion of the arm.
struct LikelyMove {
  alignment::CameraSpan span;
  std::size_t clock = 0;  ///< in `RunPosterior::robot`
};

/// What is known about a run from its signals.
struct RunPosterior {
  std::vector<LikelyTouch> touches;     ///< those with a probability of at least 0.05, by start
  std::vector<TouchInterval> releases;  ///< more likely than not, by start
  std::vector<LikelyOffset> robot;      ///< of each piece of the log in which the arm moves
  std::size_t runs_of_robot = 1;        ///< how many runs of the session tell it
  std::optional<LikelyOffset> film;     ///< where no log relates it
  std::vector<LikelyMove> arm_moves;    ///< by these, piece by piece
  std::exception_ptr failure = {};      ///< the recording cannot be read; the rest is empty
};

/// Draws from the posterior of a hidden Markov chain of what happens (`RunStates`), given the events and, for each possible
/// offset of its clock, the robot's log. @throws Error  if the recording cannot be read
RunPosterior run_posterior(const alignment::RunSignals& signals);

/// The same of the runs of a session, which share the robot's clock (`offsets_by_others`). It does not depend on the number of
/// threads. @return  in the order of the runs
std::vector<RunPosterior> session_posteriors(std::span<const alignment::RunSignals* const> runs, unsigned threads);

}  // namespace tactile::labels
