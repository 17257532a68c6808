#pragma once

#include "tactile/simulation/run_clocks.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile::simulation {

/// A run whose numbers are easy to work with: tap, press, release, press, lift, tap.
inline RunPlan planned_run() {
  RunPlan plan;
  plan.taps.push_back({.start_s = 0.3, .travel_mm = 4, .tap_s = 0.2, .depth_mm = 1});
  PressPlan press{.stage_start_s = 1.0, .contact_s = 1.3, .press_s = 0.2, .depth_mm = 1, .release_start_s = {}};
  press.release_start_s = 1.8;
  plan.presses.push_back(press);
  plan.presses.push_back({.stage_start_s = 2.5, .contact_s = 2.8, .press_s = 0.2, .depth_mm = 1, .release_start_s = {}});
  plan.lift = LiftPlan{.start_s = 3.5, .lift_s = 0.7, .speed_mm_s = 80};
  plan.taps.push_back({.start_s = 5.0, .travel_mm = 4, .tap_s = 0.2, .depth_mm = 1});
  plan.vibration = {.hz = 20, .tip_mm = 0.005, .decay_s = 0.08, .housing_share = 0.3};
  plan.end_s = 6;
  plan.stage_on_robot_output = true;
  plan.has_imu = true;
  return plan;
}

/// Robot and video begin half a second before the camera, and both clocks are off by 100 ppm.
inline RunClocks planned_clocks() {
  constexpr std::int64_t camera_us = 1'700'000'000'000'000, before_us = 500'000, up_us = 600'000'000;
  RunClocks clocks;
  clocks.session = "session-1";
  clocks.camera_start_us = camera_us;
  clocks.robot = {.offset_us = camera_us - before_us - up_us, .drift_ppm = 100, .reference_us = up_us};
  clocks.video = {.offset_us = camera_us - before_us, .drift_ppm = -100, .reference_us = 0};
  return clocks;
}

/// Since the camera's first read-out.
template <class Time>
double seconds_of(Time t, const ClockRelation& relation, const RunClocks& clocks) {
  return 1e-6 * static_cast<double>(us_of(relation.camera_from(t)) - clocks.camera_start_us);
}

}  // namespace tactile::simulation
