#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/labels/clock_anchors.hpp"
#include "tactile/labels/clock_fit.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/run_signals.hpp"

namespace tactile {

struct RobotClocksOptions {
  AnchorOptions anchors{};
  ClockFitOptions fit{};
};

/// The robot's clock in one run.
struct RobotClocks {
  std::vector<std::optional<FittedClock>> pieces;  ///< of each of the run's pieces; nothing where it could not be related
  std::vector<std::vector<ClockAnchor>> anchors;   ///< of each piece: what this run itself tells
  std::vector<std::string> doubts;                 ///< in words: why one could not be
};

/// Relates the robot's clocks of runs that share them (or of one run). Each piece is fitted by its own anchors first; then one
/// line is laid through the anchors of all runs that agree with each other, and each of them gets it with its own first stamp as
/// reference. A controller that was started anew between two runs leaves groups that do not agree; within a run, pieces that are
/// fitted by themselves.
/// @return of each run, in order
std::vector<RobotClocks> robot_clocks_of(std::span<const RunSignals* const> runs, const RobotClocksOptions& options = {});

}  // namespace tactile
