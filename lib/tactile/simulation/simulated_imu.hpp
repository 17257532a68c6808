#pragma once

#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/simulation/drawn_value.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile::simulation {

/// Properties of the inertial sensor of the camera, which moves with the arm. Noise and steps are those of a DVXplorer at rest: 3
/// mg, 0.1 degrees/s, a sample every 1.242 ms instead of the nominal 1.25 ms. The ranges are 4 g and 500 degrees/s.
struct ImuPhysics {
  double share = 0.5;  ///< of the runs that have its stream
  double rate_hz = 800;
  double rate_error = 0.01;             ///< largest relative error of the rate: the sensor has its own clock
  Range delay_us{20, 260};              ///< from a sample to its stamp
  microseconds stamp_step{200};         ///< a stamp is the time of the current read-out: a whole number of these after the first
  double acceleration_noise_g = 0.003;  ///< standard deviation of a sample
  double acceleration_bias_g = 0.02;    ///< standard deviation from run to run, each axis
  double rate_noise_dps = 0.1;
  double rate_bias_dps = 0.4;
  double tilt_rad = 0.05;  ///< of the camera against the vertical, standard deviation, each axis
  Range temperature_c{32, 42};
};

template <class Fields>
void list_fields(Fields& fields, ImuPhysics& imu) {
  fields("share", imu.share, 0.0, 1.0);
  fields("rate_hz", imu.rate_hz, 1.0, 3200.0);
  fields("rate_error", imu.rate_error, 0.0, 0.2);
  fields("delay_us", imu.delay_us, 0.0, 100'000.0);
  fields("stamp_step_us", imu.stamp_step, 1, 100'000);
  fields("acceleration_noise_g", imu.acceleration_noise_g, 0.0, 1.0);
  fields("acceleration_bias_g", imu.acceleration_bias_g, 0.0, 1.0);
  fields("rate_noise_dps", imu.rate_noise_dps, 0.0, 100.0);
  fields("rate_bias_dps", imu.rate_bias_dps, 0.0, 100.0);
  fields("tilt_rad", imu.tilt_rad, 0.0, 1.5);
  fields("temperature_c", imu.temperature_c, -40.0, 125.0);
}

/// The stream during the camera's recording: gravity, the arm's acceleration and ringing, and noise. The image's y axis points
/// down, so a camera at rest measures about (0, -1, 0) g. Times are strictly ascending.
/// @param start  the camera's first read-out
std::vector<events::ImuSample> feel_run(const RunPlan& plan, CameraTime start, const ImuPhysics& physics, Random& random);

}  // namespace tactile::simulation
