#include "tactile/labels/unlogged_lift.hpp"

#include <algorithm>
#include <vector>

#include "tactile/core/duration_units.hpp"
#include "tactile/labels/arm_moves.hpp"
#include "tactile/labels/felt_moves.hpp"

namespace tactile::labels {
namespace {

/// Whether one of the bursts lies in the move.
bool holds_one(const ArmMove& move, const alignment::EventRate& rate, std::span<const alignment::Burst> bursts,
               const std::vector<bool>& of_those) {
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    if (of_those[i] && lift_around({move}, rate, bursts[i]) != nullptr) return true;
  }
  return false;
}

ArmMove move_of(const alignment::VideoMotion& motion) {
  const microseconds start = between(motion.start.low, motion.start.high), end = between(motion.end.low, motion.end.high);
  return {.start = motion.start.at, .end = motion.end.at, .uncertainty = std::max(start, end) / 2};
}

/// How much a motion changes the film [grey levels].
double change_of(const alignment::VideoMotion& motion) {
  return motion.energy * 1e-3 * in_ms(between(motion.start.at, motion.end.at));
}

}  // namespace

std::optional<UnloggedLift> unlogged_lift(std::span<const events::ImuSample> imu, std::span<const alignment::VideoMotion> filmed,
                                          const alignment::EventRate& rate, std::span<const alignment::Burst> bursts,
                                          const std::vector<bool>& may_slip) {
  const auto last_of = [&](const std::vector<ArmMove>& moves, LiftWitness witness) -> std::optional<UnloggedLift> {
    const auto last =
        std::find_if(moves.rbegin(), moves.rend(), [&](const ArmMove& move) { return holds_one(move, rate, bursts, may_slip); });
    return last == moves.rend() ? std::nullopt : std::optional(UnloggedLift{*last, witness});
  };
  if (const auto felt = last_of(felt_moves(imu), LiftWitness::imu)) return felt;

  constexpr double much = 1.0 / 3;  // as large a share of the largest change
  const std::vector<bool> any_burst(bursts.size(), true);
  double most = 0;
  for (const alignment::VideoMotion& motion : filmed) most = std::max(most, change_of(motion));
  std::vector<ArmMove> large;
  bool shows_small = false;
  for (const alignment::VideoMotion& motion : filmed) {
    if (change_of(motion) >= much * most) {
      large.push_back(move_of(motion));
    } else {
      shows_small = shows_small || holds_one(move_of(motion), rate, bursts, any_burst);
    }
  }
  return shows_small || large.size() == 1 ? last_of(large, LiftWitness::film) : std::nullopt;
}

Doubt no_robot_log(const std::optional<UnloggedLift>& lift) {
  if (!lift) return doubt("no-robot-log", "no robot log: press and slip are distinguished by their order alone");
  return lift->witness == LiftWitness::imu
             ? doubt("lift-by-imu", "no robot log: the slip is the burst in which the camera's IMU felt the last motion")
             : doubt("lift-by-film", "no robot log: the slip is the burst in which the film shows the last large motion");
}

}  // namespace tactile::labels
