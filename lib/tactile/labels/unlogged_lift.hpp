#pragma once

#include <optional>
#include <span>

#include "tactile/alignment/event_rate.hpp"
#include "tactile/alignment/film_motions.hpp"
#include "tactile/core/doubt.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/labels/touches.hpp"

namespace tactile::labels {

enum class LiftWitness { imu, film };

/// The lift of a run without a robot log, and what shows it.
struct UnloggedLift {
  ArmMove move;
  LiftWitness witness = LiftWitness::imu;
};

/// The lift is the last motion that the IMU felt during a burst: a camera on the stage also feels the press. Without such a
/// motion it is the last one during a burst that changes the film much. A motion changes the film much if it changes at least a
/// third as many grey levels as the one that changes most: the arm carries more of the picture, and further, than the stage
/// moves. If several motions change it as much, the film must also show a motion during a burst that changes less. Otherwise the
/// arm cannot be distinguished from the stage.
/// @param imu       of one IMU
/// @param filmed    motions in the film, in camera time; empty without a film whose clock is known
/// @param may_slip  for each burst: whether it may be a slip
/// @return          nothing if neither shows a lift
std::optional<UnloggedLift> unlogged_lift(std::span<const events::ImuSample> imu, std::span<const alignment::VideoMotion> filmed,
                                          const alignment::EventRate& rate, std::span<const alignment::Burst> bursts,
                                          const std::vector<bool>& may_slip);

/// The doubt about a run without a robot log. @param lift  as `unlogged_lift` found it
Doubt no_robot_log(const std::optional<UnloggedLift>& lift);

}  // namespace tactile::labels
