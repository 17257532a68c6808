#pragma once

#include "options.hpp"
#include "tactile/core/time.hpp"

namespace tactile::cli {

/// `--camera-time`, of every command that prints times for people. @param camera_time  must outlive the command
Option add_camera_time_option(Command command, bool& camera_time);

/// The time that printed times count from: the recording's first event; with --camera-time, the zero of the camera's clock.
inline CameraTime zero_of_times(bool camera_time, CameraTime first_event) { return camera_time ? CameraTime{} : first_event; }

}  // namespace tactile::cli
