#pragma once

#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/simulation/drawn_value.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile {

/// What the camera's inertial sensor is like. The camera rides on the arm.
struct ImuPhysics {
  double share = 0.5;    ///< of the runs that have its stream
  double rate_hz = 800;
  double acceleration_noise_g = 0.006;  ///< standard deviation of a sample
  double acceleration_bias_g = 0.02;    ///< standard deviation from run to run, each axis
  double rate_noise_dps = 0.08;
  double rate_bias_dps = 0.4;
  double tilt_rad = 0.05;  ///< of the camera against the vertical, standard deviation
  Range temperature_c{32, 42};
};

/// The stream over the camera's recording: gravity, the arm's acceleration and ringing, noise. The image's y axis points down.
/// @param start  the camera's first read-out
std::vector<ImuSample> feel_run(const RunPlan& plan, CameraTime start, const ImuPhysics& physics, Random& random);

}  // namespace tactile
