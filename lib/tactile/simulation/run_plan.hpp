#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/simulation/drawn_value.hpp"
#include "tactile/simulation/object_model.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile {

/// How long the parts of a run last.
struct RunTimings {
  Range quiet_s{0.8, 1.2};    ///< before anything moves
  Range travel_s{0.15, 0.5};  ///< of the stage, before it touches
  Range hold_s{0.35, 0.7};    ///< still, between press and lift
  Range lift_s{0.5, 0.9};     ///< of the arm
  Range rest_s{1.1, 1.6};     ///< still, after the lift
};

/// How runs differ from each other. A spread is the standard deviation of the logarithm of a factor on the object's own value.
struct RunVariation {
  double depth_spread = 0.25;
  Range depth_mm{0.4, 1.9};  ///< cut to
  Range press_power{0.6, 1.4};
  double press_time_spread = 0.15;
  Range press_s{0.12, 0.4};          ///< cut to
  Range closing_speed_mm_s{4, 20};   ///< cut to
  double centre_mm = 3.0;            ///< where the object meets the skin: standard deviation each way
  Range lift_speed_mm_s{30, 120};
  Range lift_acceleration_mm_s2{1100, 1300};
  double lift_angle_rad = 0.1;  ///< standard deviation
  double slack_spread = 0.3;
  double shear_limit_spread = 0.15;
  double stick_slip_hz_spread = 0.15;
  double stick_slip_mm_spread = 0.35;
  Range unison{0.4, 0.9};
  double ring_hz_spread = 0.1;
  double ring_decay_spread = 0.15;
  double texture_spread = 0.2;
  double sink = 0.06;  ///< standard deviation
  Range veil{0.01, 0.05};
  double noise_spread = 0.25;
  double stage_output_share = 0.5;  ///< of the runs, in which the robot's output commands the stage
};

/// Motion that nobody labels, but that moves the markers.
struct AfterEffects {
  Range relaxation_share{0.005, 0.03};  ///< of the depth, by which tips creep while the stage stands still
  Range relaxation_s{0.1, 0.4};         ///< time constant
  double micro_slips_per_s = 0.5;       ///< while the object touches and nothing else moves
  Range micro_slip_mm{0.02, 0.08};
  double recontact_chance = 0.3;        ///< in the rest after a lift
  Range recontact_mm{0.05, 0.25};
  Range recontact_s{0.06, 0.15};
  Range vibration_hz{12, 28};           ///< of the arm, where it starts and stops
  Range vibration_mm{0.002, 0.01};      ///< of the markers
  Range vibration_decay_s{0.04, 0.12};
};

/// Shares of the runs that are no plain press and slip.
struct SpecialRuns {
  int from_run = 4;  ///< runs before it are plain: one of them may be the one that is learned from
  double two_presses = 0.12;
  double without_slip = 0.08;
  double without_press = 0.08;
  double taps = 0.0;  ///< with three taps at the start and at the end
};

/// A marker under the object.
struct MarkerContact {
  double gap_mm = 0;  ///< between object and tip when the first marker is touched
  double pull_x = 0;  ///< how far the tip goes aside as it is pushed in [mm per mm]
  double pull_y = 0;
  double shear_share = 1;  ///< of the lift's shear limit and stick-slip, from how well it is pressed
  double lag_share = 0;    ///< by which it sticks later than the object jerks, as a share of the stick-slip period
};

// Times of a plan are in seconds of camera time since the camera's first read-out.

/// The stage closes on the object and stands still; it may open again.
struct PressPlan {
  double stage_start_s = 0;  ///< its command; it is at speed 20 ms later
  double contact_s = 0;      ///< the first marker is touched; before 0: it is pressed when the recording begins
  double press_s = 0;        ///< from contact until the stage stands still
  double depth_mm = 0;       ///< by which the first marker is then pushed in
  double press_power = 1;    ///< closing speed falls as (1 - t / press_s)^power
  double stage_share = 1;    ///< markers' travel over the stage's: the object gives way by the rest
  double relaxation_share = 0;
  double relaxation_s = 0.2;
  std::optional<double> release_start_s;  ///< the stage opens again
  double release_s = 0.2;                 ///< until the last marker is free
  std::array<MarkerContact, marker_count> markers{};

  double closing_speed_mm_s() const { return depth_mm * (press_power + 1.0) / press_s; }  ///< at contact
  /// By which the object is pushed in [mm], creeping and release included; 0 before contact.
  double depth_at(double t_s) const;
};

/// The arm goes up, and the object does not come along.
struct LiftPlan {
  double start_s = 0;
  double lift_s = 0;  ///< the arm moves, its ramps included
  double speed_mm_s = 0;
  double acceleration_mm_s2 = 1200;
  double angle_rad = 0;  ///< of the shear against the image's y axis
  double slack_mm = 0;
  double shear_limit_mm = 0;
  double stick_slip_hz = 0;
  double stick_slip_mm = 0;
  double unison = 1;  ///< share of the tips that take part in a jerk
  double ring_hz = 0;
  double ring_decay_s = 0;
  double texture_mm = 0;
  double sink = 0;  ///< change of the markers' depth over the lift, as a share of it

  double end_s() const { return start_s + lift_s; }
  double travel_at(double t_s) const;  ///< [mm]
  double speed_at(double t_s) const;   ///< [mm/s]
  double acceleration_at(double t_s) const;
};

/// The arm sets the sensor's tips against something hard for an instant, which all clocks see.
struct TapPlan {
  double start_s = 0;    ///< the arm begins to go down
  double travel_mm = 0;  ///< there and back
  double tap_s = 0;      ///< there and back
  double depth_mm = 0;   ///< by which all tips are pushed in at the lowest point
};

/// Some tips spring back a little, and ring.
struct MicroSlipPlan {
  double at_s = 0;
  unsigned markers = 0;  ///< bit i: marker i
  double slip_mm = 0;
};

/// The object rocks: the tips come free by this much, and are pressed again.
struct RecontactPlan {
  double start_s = 0;
  double recontact_s = 0;
  double depth_mm = 0;
};

/// The arm rings where it starts and stops, and the tips with it.
struct VibrationPlan {
  double hz = 20;
  double tip_mm = 0;  ///< of the tips against the camera, along the lift, at an acceleration of 1200 mm/s^2
  double decay_s = 0.08;
};

/// Everything that one run draws before anything moves.
struct RunPlan {
  std::vector<PressPlan> presses;  ///< in order; each is open again before the next touches
  std::optional<LiftPlan> lift;
  std::vector<TapPlan> taps;
  std::vector<MicroSlipPlan> micro_slips;
  std::vector<RecontactPlan> recontacts;
  VibrationPlan vibration;
  double end_s = 0;                    ///< the camera's last read-out
  double veil = 0;                     ///< stray light, as a reflectance
  double noise_factor = 1;             ///< of the camera's noise in this run
  bool stage_on_robot_output = false;  ///< the stage is commanded through bit 0 of the robot's outputs
  bool has_imu = false;

  const PressPlan* press_at(double t_s) const;  ///< the latest that touches or has touched by then and is not released
  // The arm, up from where it stood; taps included, its ringing not.
  double arm_travel_at(double t_s) const;        ///< [mm]
  double arm_speed_at(double t_s) const;         ///< [mm/s]
  double arm_acceleration_at(double t_s) const;  ///< [mm/s^2]
  /// Of the tips along the lift [mm]: started by each change of the arm's acceleration, in proportion to it.
  double vibration_at(double t_s) const;
  double vibration_acceleration_at(double t_s) const;  ///< of the camera's housing, which rings with it [mm/s^2]
  double stage_travel_at(double t_s) const;            ///< of the stage towards the object since the run began [mm]
  bool stage_commanded_at(double t_s) const;           ///< shut, rather than open
};

void to_json(nlohmann::json& json, const RunPlan& plan);

struct RunPlanOptions {
  RunTimings timings;
  RunVariation variation;
  AfterEffects after;
  SpecialRuns special;
  double imu_share = 0.5;   ///< of the runs that have an IMU stream
  int run_number = 1;       ///< from 1
  bool may_be_special = false;
};

/// Draws a run with `object`. Each number comes from a stated distribution round the object's, so that neither a region of the
/// image nor the mere count of events gives a class away.
RunPlan draw_run_plan(const ObjectModel& object, const RunPlanOptions& options, Random& random);

}  // namespace tactile
