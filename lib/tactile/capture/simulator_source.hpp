#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tactile/capture/camera_source.hpp"

namespace tactile::capture {

/// The simulator as a live camera: the read-outs of runs as of `simulate --preset quick`, in packets of 1 ms. The camera's clock
/// continues from run to run. The IMU is on in every run.
///
/// After `begin_run` it produces one run, determined by the seed, the object and the run's name, and then ends until the next
/// `begin_run`. `end_run` writes the robot's log, the film and the truth of the recorded part. The first run has the same events
/// and clocks as with `simulate`. A later run has them at a later time, on the same clocks of camera and controller. Without
/// `begin_run` there is run after run without end.
///
/// @param name    the source as the user wrote it
/// @param object  the touched object; nothing: the object of `begin_run` if it is one of the ten, else the water bottle
/// @throws Error  if there is no such object
std::unique_ptr<CameraSource> open_simulator_source(std::string name, std::optional<std::string> object, double speed,
                                                    std::uint64_t seed);

}  // namespace tactile::capture
