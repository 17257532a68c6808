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

/// Relates the robot's clocks of runs that share them (or of one run): one line is laid through the anchors of all of them, and
/// each run gets it with its own first stamp as reference. A controller that started anew within a run counts from elsewhere in
/// each piece, so that such a run's pieces are fitted by themselves.
/// @return of each run, in order
std::vector<RobotClocks> robot_clocks_of(std::span<const RunSignals* const> runs, const RobotClocksOptions& options = {});

}  // namespace tactile
