#include "tactile/labels/arm_moves.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace tactile::labels {
ArmMoves arm_moves(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks) {
  ArmMoves moves;
  for (std::size_t i = 0; i < signals.robot.size(); ++i) {
    moves.logged += signals.robot[i].log.states.back().t - signals.robot[i].log.states.front().t;
    for (const alignment::MotionPhase& phase : signals.robot[i].phases) {
      if (phase.kind != alignment::MotionKind::lift && phase.kind != alignment::MotionKind::tap) continue;
      const bool is_lift = phase.kind == alignment::MotionKind::lift;
      moves.rises = moves.rises || is_lift;
      if (is_lift && phase.profile) moves.rings = moves.rings.value_or(false) || phase.profile->rings();
      if (!clocks.pieces[i]) {
        moves.all_placed = moves.all_placed && !is_lift;
        continue;
      }
      const alignment::FittedClock& clock = *clocks.pieces[i];
      (is_lift ? moves.lifts : moves.taps)
          .push_back(
              {clock.relation.camera_from(phase.start), clock.relation.camera_from(phase.end), clock.uncertainty(), &phase});
    }
  }
  return moves;
}

std::optional<double> travel_until(const ArmMove& move, CameraTime t) {
  if (move.phase == nullptr || !move.phase->profile) return std::nullopt;
  constexpr double step_s = 1e-3;
  const double until_s = 1e-6 * static_cast<double>(between(move.start, std::clamp(t, move.start, move.end)).count());
  double travel = 0;
  for (int i = 0; i < static_cast<int>(until_s / step_s); ++i)
    travel += step_s * move.phase->profile->commanded_m_s((i + 0.5) * step_s);
  return travel;
}

const ArmMove* lift_around(const std::vector<ArmMove>& lifts, const alignment::EventRate& rate, const alignment::Burst& burst) {
  const auto overlaps = [&](const ArmMove& lift) {
    return rate.begin_of(burst.begin) < after(lift.end, lift.uncertainty) &&
           rate.begin_of(burst.end) > before(lift.start, lift.uncertainty);
  };
  const auto lift = std::find_if(lifts.begin(), lifts.end(), overlaps);
  return lift == lifts.end() ? nullptr : &*lift;
}

}  // namespace tactile::labels
