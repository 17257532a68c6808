#pragma once

#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/alignment/session_clocks.hpp"
#include "tactile/labels/touches.hpp"

namespace tactile::labels {

constexpr microseconds well_placed = 30ms;  ///< a lift whose clock is known so well splits and joins bursts

/// The lifts and taps of a run, in camera time.
struct ArmMoves {
  std::vector<ArmMove> lifts, taps;
  bool rises = false;           ///< the log has a lift
  std::optional<bool> rings{};  ///< whether the arm oscillates in one of them; nothing where no lift is fitted
  bool all_placed = true;       ///< the clock of every piece with a lift is known
  microseconds logged{0};       ///< time that the log covers
};

ArmMoves arm_moves(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks);

/// How far the arm has moved by `t` [m], as it was commanded; nothing where no profile was fitted.
std::optional<double> travel_until(const ArmMove& move, CameraTime t);

/// The lift that the burst lies in; null if there is none.
const ArmMove* lift_around(const std::vector<ArmMove>& lifts, const alignment::EventRate& rate, const alignment::Burst& burst);

}  // namespace tactile::labels
