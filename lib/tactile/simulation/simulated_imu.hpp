#pragma once

#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/simulation/drawn_value.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile {

/// What the camera's inertial sensor is like. The camera rides on the arm. Noise and steps are those of a DVXplorer at rest: 3
/// mg, 0.1 degrees/s, a sample every 1.242 ms where 1.25 ms are asked for. The sensor's ranges are 4 g and 500 degrees/s.
struct ImuPhysics {
  double share = 0.5;  ///< of the runs that have its stream
  double rate_hz = 800;
  double rate_error = 0.01;             ///< the rate is off by up to this share: the sensor has a clock of its own
  Range delay_us{20, 260};              ///< from a sample to its stamp
  microseconds stamp_step{200};         ///< a stamp is the time of the read-out going on: a whole number of these since the first
  double acceleration_noise_g = 0.003;  ///< standard deviation of a sample
  double acceleration_bias_g = 0.02;    ///< standard deviation from run to run, each axis
  double rate_noise_dps = 0.1;
  double rate_bias_dps = 0.4;
  double tilt_rad = 0.05;  ///< of the camera against the vertical, standard deviation, each way
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

/// The stream over the camera's recording, and no further: gravity, the arm's acceleration and ringing, noise. The image's y axis
/// points down and the arm goes up it, so that a camera at rest feels about (0, -1, 0) g. Times ascend, none comes twice.
/// @param start  the camera's first read-out
std::vector<ImuSample> feel_run(const RunPlan& plan, CameraTime start, const ImuPhysics& physics, Random& random);

}  // namespace tactile
