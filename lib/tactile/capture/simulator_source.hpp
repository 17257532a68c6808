#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tactile/capture/camera_source.hpp"

namespace tactile {

/// The simulator as a live camera: the read-outs of runs as `simulate --preset quick` makes them, in packets of 1 ms, on a camera
/// clock that goes on from run to run. Its inertial sensor is on in every run.
///
/// After `begin_run` it gives one run, drawn from the seed, the object and the run's name, and then ends until the next
/// `begin_run`; `end_run` writes what the robot, the webcam and the truth have to say of the part that was recorded. The first
/// run has the very events and clocks that `simulate` gives it; a later one has them at a later time, on the same camera's and
/// controller's clocks. Without `begin_run` it gives run after run, for ever.
///
/// @param name    the source as the user wrote it
/// @param object  what is touched; where it is not given, what `begin_run` names if it is one of the ten, else the water bottle
/// @throws Error  if there is no such object
std::unique_ptr<CameraSource> open_simulator_source(std::string name, std::optional<std::string> object, double speed,
                                                    std::uint64_t seed);

}  // namespace tactile
