#pragma once

#include <span>
#include <string>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/alignment/session_clocks.hpp"
#include "tactile/core/doubt.hpp"
#include "tactile/labels/arm_moves.hpp"
#include "tactile/labels/touches.hpp"

namespace tactile::labels {

/// The bursts of a run that a person should know of: they may lack a label, or no log confirms theirs.
struct UnlabelledBursts {
  /// A burst that moves the skin like a press, but is none (`burst-unexplained`), and one after the robot log's end, which may be
  /// the slip of a lift that was not logged (`burst-unlogged`).
  std::vector<Doubt> doubts;
  std::string remark;  ///< the other bursts without a label, each with the reason; empty if there are none
};

/// @param bursts  of the run, by time
/// @param kinds   of each burst, by `kinds_of`
UnlabelledBursts unlabelled_bursts(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
                                   const ArmMoves& moves, std::span<const alignment::Burst> bursts,
                                   std::span<const BurstKind> kinds, const TouchesOptions& options);

}  // namespace tactile::labels
