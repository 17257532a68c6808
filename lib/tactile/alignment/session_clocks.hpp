#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/alignment/clock_anchors.hpp"
#include "tactile/alignment/clock_fit.hpp"
#include "tactile/alignment/run_signals.hpp"
#include "tactile/core/doubt.hpp"

namespace tactile::alignment {

struct RobotClocksOptions {
  AnchorOptions anchors{};
  ClockFitOptions fit{};
};

/// The robot's clock in one run.
struct RobotClocks {
  std::vector<std::optional<FittedClock>> pieces;  ///< of each of the run's pieces; nothing where it could not be related
  std::vector<std::vector<ClockAnchor>> anchors;   ///< of each piece, by this run itself
  std::vector<Doubt> doubts;                       ///< why a clock could not be related
  std::vector<Doubt> contradictions;               ///< why log and recording may not belong together
};

/// Relates the robot's clocks of runs that share them (or of one run). Each piece is fitted by its own anchors first. Then
/// one line is fitted to the anchors of all runs that agree with each other; each of them gets it, with its own first stamp as
/// reference. A controller that restarts between two runs leaves groups that do not agree. Pieces of one run are fitted by
/// themselves.
/// @return  of each run, in order
std::vector<RobotClocks> robot_clocks_of(std::span<const RunSignals* const> runs, const RobotClocksOptions& options = {});

}  // namespace tactile::alignment
