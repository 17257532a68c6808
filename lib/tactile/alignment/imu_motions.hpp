#pragma once

#include <span>
#include <vector>

#include "tactile/alignment/camera_span.hpp"
#include "tactile/events/other_streams.hpp"

namespace tactile::alignment {

/// Motions of the camera by its IMU alone, by time: a push that is followed by its opposite, as those of an arm that starts and
/// stops. For runs without a robot log. A camera on the stage also feels the press. Start and end are known within 30 ms.
/// @param samples  of one IMU; fewer than 50 give none
std::vector<CameraSpan> imu_motions(std::span<const events::ImuSample> samples);

}  // namespace tactile::alignment
