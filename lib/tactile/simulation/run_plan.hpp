#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "tactile/core/clock_relation.hpp"
#include "tactile/core/random.hpp"
#include "tactile/simulation/object_model.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile {

/// A range that a run's value is drawn from, every value alike.
struct Range {
  double low = 0;
  double high = 0;
};

/// How long the parts of a run last.
struct RunTimings {
  Range quiet_s{0.8, 1.2};    ///< before anything moves
  Range travel_s{0.15, 0.5};  ///< of the stage, before it touches
  Range hold_s{0.35, 0.7};    ///< still, between press and lift
  Range lift_s{0.5, 0.9};     ///< of the arm
  Range rest_s{1.1, 1.6};     ///< still, after the lift
};

void to_json(nlohmann::json& json, const RunTimings& timings);

/// A marker under the object.
struct MarkerContact {
  double gap_mm = 0;  ///< between object and tip when the first marker is touched
  double pull_x = 0;  ///< how far the tip goes aside as it is pushed in [mm per mm]
  double pull_y = 0;
  double shear_share = 1;  ///< of the run's shear limit and stick-slip, from how well it is pressed
  double lag_share = 0;    ///< by which it sticks later than the object jerks, as a share of the stick-slip period
};

/// Everything that one run draws before anything moves. Times are in seconds of camera time since the camera's first read-out.
struct RunPlan {
  double stage_start_s = 0;  ///< the stage's command; it is at speed 20 ms later
  double contact_s = 0;      ///< the first marker is touched
  double press_s = 0;        ///< from contact until the stage stands still
  double depth_mm = 0;       ///< by which the first marker is then pushed in
  double press_power = 1;    ///< closing speed falls as (1 - t / press_s)^power
  double stage_share = 1;    ///< markers' travel over the stage's: the object gives way by the rest
  double lift_start_s = 0;
  double lift_s = 0;  ///< the arm moves, its ramps included
  double lift_speed_mm_s = 0;
  double lift_acceleration_mm_s2 = 1200;
  double lift_angle_rad = 0;  ///< of the shear against the image's y axis
  double end_s = 0;           ///< the camera's last read-out

  double slack_mm = 0;
  double shear_limit_mm = 0;
  double stick_slip_hz = 0;
  double stick_slip_mm = 0;
  double unison = 1;  ///< share of the tips that take part in a jerk
  double ring_hz = 0;
  double ring_decay_s = 0;
  double texture_mm = 0;
  double sink = 0;  ///< change of the markers' depth over the lift, as a share of it

  std::array<MarkerContact, marker_count> markers{};
  double veil = 0;                     ///< stray light, as a reflectance
  double noise_factor = 1;             ///< of the camera's noise in this run
  bool stage_on_robot_output = false;  ///< the stage was commanded through bit 0 of the robot's outputs

  double closing_speed_mm_s() const { return depth_mm * (press_power + 1.0) / press_s; }  ///< at contact
  double depth_at(double t_s) const;         ///< by which the object is pushed in [mm]; 0 before contact
  double lift_travel_at(double t_s) const;   ///< of the arm [mm]
  double lift_speed_at(double t_s) const;    ///< [mm/s]
  double stage_travel_at(double t_s) const;  ///< of the stage since its command [mm]
};

void to_json(nlohmann::json& json, const RunPlan& plan);

/// Draws a run with `object`. Each number comes from a stated distribution round the object's, so that neither a region of the
/// image nor the mere count of events gives a class away.
RunPlan draw_run_plan(const ObjectModel& object, const RunTimings& timings, Random& random);

/// A run's clocks, each started at another time and running at another rate.
struct RunClocks {
  std::int64_t camera_start_us = 0;  ///< the camera's first read-out
  ClockRelation robot, video;        ///< to the camera's
  std::int64_t host_from_camera_us = 0;
};

RunClocks draw_run_clocks(Random& random);

/// The clocks of a later run of one session: camera, robot and video go on as they ran in the session's `first` run, the camera's
/// first read-out is at `start`, and robot and video begin as much earlier as they do in `drawn`. A video always counts from 0.
RunClocks continued_clocks(const RunClocks& drawn, const RunClocks& first, CameraTime start);

}  // namespace tactile
