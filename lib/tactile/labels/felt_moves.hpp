#pragma once

#include <span>
#include <vector>

#include "tactile/events/other_streams.hpp"
#include "tactile/labels/touches.hpp"

namespace tactile::labels {

/// Motions of the camera by its IMU alone, by time: a push that is followed by its opposite, as those of an arm that starts and
/// stops. For runs without a robot log: it shows which burst of events an arm caused.
/// @param samples  of one IMU; fewer than 50 give none
std::vector<ArmMove> felt_moves(std::span<const events::ImuSample> samples);

}  // namespace tactile::labels
