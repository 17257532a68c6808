#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/simulation/drawn_value.hpp"
#include "tactile/simulation/event_camera_options.hpp"
#include "tactile/simulation/object_model.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile::simulation {

/// The durations of the parts of a run.
struct RunTimings {
  Range quiet_s{0.8, 1.2};    ///< before any motion
  Range travel_s{0.15, 0.5};  ///< of the stage, before contact
  Range hold_s{0.35, 0.7};    ///< still, between press and lift
  Range lift_s{0.5, 0.9};     ///< of the arm
  Range rest_s{1.1, 1.6};     ///< still, after the lift
  Range between_s{0.4, 0.7};  ///< open, between two presses
};

template <class Fields>
void list_fields(Fields& fields, RunTimings& t) {
  fields("quiet_s", t.quiet_s, 0.1, 60.0);
  fields("travel_s", t.travel_s, 0.03, 10.0);
  fields("hold_s", t.hold_s, 0.05, 60.0);
  fields("lift_s", t.lift_s, 0.05, 10.0);
  fields("rest_s", t.rest_s, 0.2, 60.0);
  fields("between_s", t.between_s, 0.05, 60.0);
}

/// The variation between runs. A spread is the standard deviation of the logarithm of a factor on the object's value. None of it
/// is published. Press and lift are within the limits of the sensor and its stage (0-2 mm inward, 4-20 mm/s), slip is within the
/// ranges reported for slip sensing (shear of 0.2-1.5 mm, stick-slip of 10-60 Hz, ringing of 60-300 Hz). The rest is assumed.
struct RunVariation {
  /// Of each spread and range of press and lift, veil and vibration: new in each run. The rest is drawn once for each object, and
  /// all its runs have it.
  double new_share = 0.1;
  // Press.
  double depth_spread = 0.25;
  Range depth_mm{0.4, 1.9};  ///< limits
  Range press_power{0.6, 1.4};
  double press_time_spread = 0.15;
  Range press_s{0.12, 0.4};         ///< limits
  Range closing_speed_mm_s{4, 20};  ///< limits
  Range release_s{0.1, 0.25};       ///< from the opening of the stage until the last marker is free
  double centre_mm = 2.5;           ///< centre of contact: standard deviation in each direction
  double edge_gradient = 2.0;       ///< gradient of the surface outside the object's edge [mm per mm]
  // A tip that is pushed inward also moves sideways: towards the contact's centre, by a part common to all tips because the stage
  // does not push straight, and by an individual part [all in mm per mm].
  Range pull{0.8, 1.5};          ///< towards the contact's centre; below 0: away from it
  double pull_full_mm = 9.0;     ///< from this distance on it is full; less inside
  double skid = 0.25;            ///< of all tips: standard deviation in each direction
  double pull_scatter_x = 0.12;  ///< of each tip along its ridge: standard deviation
  double pull_scatter_y = 0.25;  ///< the same over its thin side, to which it bends more easily
  // Lift.
  Range lift_speed_mm_s{30, 120};
  Range lift_acceleration_mm_s2{1100, 1300};
  double lift_angle_rad = 0.1;  ///< standard deviation
  double slack_spread = 0.3;
  Range slack_mm{0.005, 0.2};  ///< limits
  double shear_limit_spread = 0.15;
  Range shear_limit_mm{0.2, 1.5};     ///< limits
  double light_share = 0.5;           ///< share of the shear limit of a tip that is barely pressed
  double marker_shear_spread = 0.12;  ///< between markers
  double stick_slip_hz_spread = 0.15;
  Range stick_slip_hz{10, 60};  ///< limits
  double stick_slip_mm_spread = 0.35;
  double most_spring_back = 0.8;     ///< of the shear limit, in one stick-slip
  double light_object_g = 15;        ///< weight at which an object follows half of the spring-back; heavier ones follow less
  double stick_slip_jitter = 0.15;   ///< of a period: standard deviation, as a share
  double spring_back_jitter = 0.25;  ///< of each spring-back: standard deviation of its logarithm
  double limit_jitter = 0.05;        ///< of each tip's limit from jerk to jerk: standard deviation, as a share
  Range unison{0.4, 0.9};
  Range lag_share{0.0, 0.6};
  double ring_hz_spread = 0.1;
  Range ring_hz{60, 300};  ///< limits
  double ring_decay_spread = 0.15;
  double texture_spread = 0.2;
  Range texture_memory_s{0.003, 0.003};  ///< correlation time of the tremble
  double sink = 0.06;                    ///< standard deviation
  // All.
  Range skin_coupling{0.06, 0.06};  ///< share by which less pressed markers follow the mean: the skin is one piece
  Range veil{0.01, 0.05};
  Range object_veil{0.0, 0.04};  ///< additional stray light from an object of reflectivity 1
  double noise_spread = 0.05;
  Range light_drift{0.0, 0.01};     ///< amplitude of the slow drift of the light, as a share
  Range light_drift_s{5, 40};       ///< its period
  double stage_output_share = 0.5;  ///< share of the runs in which the robot's output commands the stage
};

template <class Fields>
void list_fields(Fields& fields, RunVariation& v) {
  fields("new_share", v.new_share, 0.0, 1.0);
  fields("depth_spread", v.depth_spread, 0.0, 2.0);
  fields("depth_mm", v.depth_mm, 0.05, 2.0);
  fields("press_power", v.press_power, 0.1, 10.0);
  fields("press_time_spread", v.press_time_spread, 0.0, 2.0);
  fields("press_s", v.press_s, 0.02, 10.0);
  fields("closing_speed_mm_s", v.closing_speed_mm_s, 0.1, 200.0);
  fields("release_s", v.release_s, 0.02, 10.0);
  fields("centre_mm", v.centre_mm, 0.0, 10.0);
  fields("edge_slope", v.edge_gradient, 0.0, 100.0);
  fields("pull", v.pull, -1.0, 2.0);
  fields("pull_full_mm", v.pull_full_mm, 0.1, 100.0);
  fields("skid", v.skid, 0.0, 1.0);
  fields("pull_scatter_x", v.pull_scatter_x, 0.0, 1.0);
  fields("pull_scatter_y", v.pull_scatter_y, 0.0, 1.0);
  fields("lift_speed_mm_s", v.lift_speed_mm_s, 1.0, 1000.0);
  fields("lift_acceleration_mm_s2", v.lift_acceleration_mm_s2, 10.0, 10'000.0);
  fields("lift_angle_rad", v.lift_angle_rad, 0.0, 1.0);
  fields("slack_spread", v.slack_spread, 0.0, 2.0);
  fields("slack_mm", v.slack_mm, 0.001, 2.0);
  fields("shear_limit_spread", v.shear_limit_spread, 0.0, 2.0);
  fields("shear_limit_mm", v.shear_limit_mm, 0.01, 2.0);
  fields("light_share", v.light_share, 0.0, 1.0);
  fields("marker_shear_spread", v.marker_shear_spread, 0.0, 1.0);
  fields("stick_slip_hz_spread", v.stick_slip_hz_spread, 0.0, 2.0);
  fields("stick_slip_hz", v.stick_slip_hz, 1.0, 500.0);
  fields("stick_slip_mm_spread", v.stick_slip_mm_spread, 0.0, 2.0);
  fields("most_spring_back", v.most_spring_back, 0.0, 1.0);
  fields("light_object_g", v.light_object_g, 0.0, 10'000.0);
  fields("stick_slip_jitter", v.stick_slip_jitter, 0.0, 0.45);
  fields("spring_back_jitter", v.spring_back_jitter, 0.0, 2.0);
  fields("limit_jitter", v.limit_jitter, 0.0, 0.4);
  fields("unison", v.unison, 0.0, 1.0);
  fields("lag_share", v.lag_share, 0.0, 1.0);
  fields("ring_hz_spread", v.ring_hz_spread, 0.0, 2.0);
  fields("ring_hz", v.ring_hz, 1.0, 1000.0);
  fields("ring_decay_spread", v.ring_decay_spread, 0.0, 2.0);
  fields("texture_spread", v.texture_spread, 0.0, 2.0);
  fields("texture_memory_s", v.texture_memory_s, 1e-4, 1.0);
  fields("sink", v.sink, 0.0, 0.3);
  fields("skin_coupling", v.skin_coupling, 0.0, 1.0);
  fields("veil", v.veil, 0.0, 10.0);
  fields("object_veil", v.object_veil, 0.0, 10.0);
  fields("noise_spread", v.noise_spread, 0.0, 2.0);
  fields("light_drift", v.light_drift, 0.0, 0.4);
  fields("light_drift_s", v.light_drift_s, 0.1, 1e4);
  fields("stage_output_share", v.stage_output_share, 0.0, 1.0);
}

/// Unlabelled motion of the markers. All values are assumptions, small against press and slip.
struct AfterEffects {
  Range relaxation_share{0.002, 0.015};  ///< of the depth, by which tips creep while the stage is still
  Range relaxation_s{0.3, 1.0};          ///< time constant
  double micro_slips_per_s = 0.2;        ///< while the object touches and only creeps
  Range micro_slip_mm{0.02, 0.08};
  double micro_slip_share = 0.35;  ///< share of the touched markers that take part, at least one
  double recontact_chance = 0.3;   ///< in the rest after a lift
  Range recontact_mm{0.05, 0.25};
  Range recontact_s{0.06, 0.15};
  double settle_s = 0.12;             ///< distance of micro-slips and re-contacts from other motion
  double after_lift_s = 0.4;          ///< the same from the end of the lift, when a slip has surely ended
  Range vibration_hz{12, 28};         ///< of the arm, at start and stop
  Range vibration_mm{0.0003, 0.005};  ///< a / (2 pi f)^2 of tips that ring at f = 80 to 300 Hz, at a = 1200 mm/s^2
  Range vibration_decay_s{0.04, 0.12};
  Range vibration_housing{0.1, 0.5};  ///< initial acceleration of the camera's housing, as a share of the arm's
  // At any time while the object is held, also right before and right after a lift.
  double free_micro_slips_per_s = 0.1;
  double partial_slips_per_s = 0.05;  ///< some of the touched tips slide a little, for a while
  Range partial_slip_mm{0.05, 0.3};
  Range partial_slip_s{0.03, 0.25};
  double turn_chance = 0.1;  ///< of a run: the object turns against the skin, and the tips follow
  Range turn_rad{0.005, 0.03};
  Range turn_s{0.1, 0.5};
  Range hysteresis_share{0.02, 0.1};  ///< of its displacement, that a tip keeps when the object leaves it
  Range hysteresis_s{0.3, 1.5};       ///< time constant with which it returns
};

template <class Fields>
void list_fields(Fields& fields, AfterEffects& a) {
  fields("relaxation_share", a.relaxation_share, 0.0, 0.2);
  fields("relaxation_s", a.relaxation_s, 0.001, 10.0);
  fields("micro_slips_per_s", a.micro_slips_per_s, 0.0, 20.0);
  fields("micro_slip_mm", a.micro_slip_mm, 0.0, 0.5);
  fields("micro_slip_share", a.micro_slip_share, 0.0, 1.0);
  fields("recontact_chance", a.recontact_chance, 0.0, 1.0);
  fields("recontact_mm", a.recontact_mm, 0.0, 2.0);
  fields("recontact_s", a.recontact_s, 0.005, 10.0);
  fields("settle_s", a.settle_s, 0.05, 10.0);
  fields("after_lift_s", a.after_lift_s, 0.3, 10.0);
  fields("vibration_hz", a.vibration_hz, 1.0, 500.0);
  fields("vibration_mm", a.vibration_mm, 0.0, 0.2);
  fields("vibration_decay_s", a.vibration_decay_s, 0.001, 1.0);
  fields("vibration_housing", a.vibration_housing, 0.0, 1.0);
  fields("free_micro_slips_per_s", a.free_micro_slips_per_s, 0.0, 20.0);
  fields("partial_slips_per_s", a.partial_slips_per_s, 0.0, 20.0);
  fields("partial_slip_mm", a.partial_slip_mm, 0.0, 2.0);
  fields("partial_slip_s", a.partial_slip_s, 0.002, 10.0);
  fields("turn_chance", a.turn_chance, 0.0, 1.0);
  fields("turn_rad", a.turn_rad, 0.0, 0.2);
  fields("turn_s", a.turn_s, 0.01, 10.0);
  fields("hysteresis_share", a.hysteresis_share, 0.0, 0.5);
  fields("hysteresis_s", a.hysteresis_s, 0.01, 60.0);
}

/// Shares of the runs that are not a plain press and slip.
struct SpecialRuns {
  int from_run = 4;  ///< earlier runs are plain: one of them may be the training run
  double two_presses = 0.12;
  double without_slip = 0.08;
  double without_press = 0.08;
  double firm_lifts = 0.08;    ///< the object comes along with the arm: a short shear, then no slip
  Range firm_shear{0.3, 0.8};  ///< of the shear limit
  double taps = 0.0;           ///< with taps at the start and at the end
  int tap_count = 3;           ///< each time
  Range tap_travel_mm{2.0, 4.0};
  Range tap_s{0.2, 0.3};        ///< there and back
  Range tap_pause_s{0.2, 0.5};  ///< from one to the next
  Range tap_depth_mm{0.2, 0.6};
};

template <class Fields>
void list_fields(Fields& fields, SpecialRuns& s) {
  fields("from_run", s.from_run, 1, 99);
  fields("two_presses", s.two_presses, 0.0, 1.0);
  fields("without_slip", s.without_slip, 0.0, 1.0);
  fields("without_press", s.without_press, 0.0, 1.0);
  fields("firm_lifts", s.firm_lifts, 0.0, 1.0);
  fields("firm_shear", s.firm_shear, 0.01, 0.95);
  fields("taps", s.taps, 0.0, 1.0);
  fields("tap_count", s.tap_count, 1, 20);
  fields("tap_travel_mm", s.tap_travel_mm, 0.1, 50.0);
  fields("tap_s", s.tap_s, 0.05, 5.0);
  fields("tap_pause_s", s.tap_pause_s, 0.05, 10.0);
  fields("tap_depth_mm", s.tap_depth_mm, 0.0, 2.0);
}

/// A marker under the object.
struct MarkerContact {
  double gap_mm = 0;  ///< between object and tip at first contact
  double pull_x = 0;  ///< sideways motion of the tip per inward motion [mm per mm]
  double pull_y = 0;
  double shear_share = 1;  ///< of the lift's shear limit and stick-slip, depending on its pressure
  double lag_share = 0;    ///< delay of its sticking after a jerk, as a share of the stick-slip period
};

// Times of a plan are in seconds of camera time since the camera's first read-out.

/// Slower than this share of the peak speed is still, by the rule of labels.
inline constexpr double still_share = 0.01;
/// Motion ends when its rest is below this: a hundredth of a pixel, invisible to the camera.
inline constexpr double least_motion_mm = 0.0006;
/// A tip that is pressed less than this is not dragged.
inline constexpr double least_pressed_mm = 0.02;

/// The stage closes on the object and stays; it may open again.
struct PressPlan {
  double stage_start_s = 0;  ///< its command; it reaches its speed 20 ms later
  double contact_s = 0;      ///< contact with the first marker; below 0: pressed when the recording begins
  double press_s = 0;        ///< from contact until the stage is still
  double depth_mm = 0;       ///< final depth of the first marker
  double press_power = 1;    ///< closing speed falls as (1 - t / press_s)^power
  double stage_share = 1;    ///< markers' travel / stage's travel: the object yields by the rest
  double relaxation_share = 0;
  double relaxation_s = 0.2;
  std::optional<double> release_start_s;  ///< the stage opens again
  double release_s = 0.2;                 ///< until the last marker is free
  std::array<MarkerContact, marker_count> markers{};

  double closing_speed_mm_s() const { return depth_mm * (press_power + 1.0) / press_s; }  ///< at contact
  double still_s() const { return contact_s + press_s; }  ///< the stage is still; the tips still creep
  /// Creeping ends when less than `least_motion_mm` remains.
  double creeping_end_s() const;
  /// Depth of the object [mm], creeping and release included; 0 before contact.
  double depth_at(double t_s) const;
  double speed_at(double t_s) const;  ///< its speed [mm/s], below 0 during release
};

/// The arm moves up, and the object stays.
struct LiftPlan {
  double start_s = 0;
  double lift_s = 0;  ///< duration of the arm's motion, ramps included
  double speed_mm_s = 0;
  double acceleration_mm_s2 = 1200;
  double angle_rad = 0;  ///< of the shear against the image's y axis
  double slack_mm = 0;
  double shear_limit_mm = 0;
  double stick_slip_hz = 0;
  double stick_slip_mm = 0;
  double unison = 1;                 ///< share of the tips that take part in a jerk
  double stick_slip_jitter = 0.15;   ///< of a period: standard deviation, as a share
  double spring_back_jitter = 0.25;  ///< standard deviation of its logarithm
  double limit_jitter = 0.05;        ///< standard deviation, as a share
  double ring_hz = 0;
  double ring_decay_s = 0;
  double texture_mm = 0;
  double texture_memory_s = 0.003;
  double sink = 0;     ///< relative change of the markers' depth over the lift
  double firm_mm = 0;  ///< > 0: the object comes along after this shear, and nothing slips

  double end_s() const { return start_s + lift_s; }
  double travel_at(double t_s) const;  ///< [mm]
  double speed_at(double t_s) const;   ///< [mm/s]
  double acceleration_at(double t_s) const;
  double time_of_travel(double mm) const;  ///< of 0 to the whole travel; infinite beyond [s]
};

/// The arm taps the sensor's tips against something hard. All devices record it.
struct TapPlan {
  double start_s = 0;    ///< the arm begins to move down
  double travel_mm = 0;  ///< there and back
  double tap_s = 0;      ///< there and back
  double depth_mm = 0;   ///< of all tips at the lowest point, at most half of the travel

  double end_s() const { return start_s + tap_s; }
  double fall_at(double t_s) const;   ///< of the arm, 0 to travel_mm: it accelerates, brakes, and returns the same way [mm]
  double speed_at(double t_s) const;  ///< downwards [mm/s]
  double acceleration_at(double t_s) const;
  double depth_at(double t_s) const;  ///< of the tips [mm]
  double contact_s() const;           ///< first contact
  double free_s() const { return 2.0 * start_s + tap_s - contact_s(); }
};

/// Some tips spring back a little, and ring. Or they slide back slowly, by at most 0.8 of their displacement: a partial slip.
struct MicroSlipPlan {
  double at_s = 0;
  double slip_s = 0;     ///< > 0: a partial slip that lasts this long
  unsigned markers = 0;  ///< bit i: marker i
  double slip_mm = 0;
  double ring_hz = 150;
  double ring_decay_s = 0.007;
};

/// The object turns against the skin. The touched tips move with it about the middle of the skin.
struct TurnPlan {
  double start_s = 0;
  double turn_s = 0;
  double angle_rad = 0;  ///< clockwise in the image

  double end_s() const { return start_s + turn_s; }
  double angle_at(double t_s) const;  ///< it begins and ends slowly: smoothstep
};

/// The object rocks: the tips are released by this depth, and pressed again.
struct RecontactPlan {
  double start_s = 0;
  double recontact_s = 0;
  double depth_mm = 0;

  double end_s() const { return start_s + recontact_s; }
  double freed_at(double t_s) const;  ///< [mm]
};

/// The arm rings at start and stop, and the tips with it.
struct VibrationPlan {
  double hz = 20;
  double tip_mm = 0;  ///< of the tips relative to the camera, along the lift, at an acceleration of 1200 mm/s^2
  double decay_s = 0.08;
  double housing_share = 0.3;  ///< initial acceleration of the camera's housing, as a share of the arm's

  /// Duration of ringing after a change of the arm's acceleration by `change_mm_s2`, until less than `least_motion_mm` remains.
  double lasts_s(double change_mm_s2) const;
};

/// All random draws of a run.
struct RunPlan {
  std::vector<PressPlan> presses;  ///< in order; each is released before the next contact
  std::optional<LiftPlan> lift;
  std::vector<TapPlan> taps;
  std::vector<MicroSlipPlan> micro_slips;
  std::vector<RecontactPlan> recontacts;
  std::vector<TurnPlan> turns;
  VibrationPlan vibration;
  double end_s = 0;             ///< the camera's last read-out
  double skin_coupling = 0.06;  ///< less pressed markers follow the mean by this share
  double hysteresis_share = 0;  ///< of its displacement, that a tip keeps when it is released
  double hysteresis_s = 1;      ///< time constant of its return
  double veil = 0;              ///< stray light, as a reflectance
  LightDrift light_drift;
  double noise_factor = 1;             ///< of the camera's noise in this run
  bool stage_on_robot_output = false;  ///< bit 0 of the robot's outputs commands the stage
  bool has_imu = false;

  const PressPlan* press_at(double t_s) const;  ///< the latest press with contact that is not released
  // The arm, upwards from its start; with taps, without ringing.
  double arm_travel_at(double t_s) const;        ///< [mm]
  double arm_speed_at(double t_s) const;         ///< [mm/s]
  double arm_acceleration_at(double t_s) const;  ///< [mm/s^2]
  /// The changes of the arm's acceleration: time [s] and change [mm/s^2], by time.
  std::vector<std::pair<double, double>> arm_acceleration_changes() const;
  /// Displacement of the tips along the lift [mm]: each is a mass on a spring. It lags while the arm accelerates, and overshoots
  /// and rings at each change of the arm's acceleration.
  double vibration_at(double t_s) const;
  double vibration_acceleration_at(double t_s) const;  ///< of the camera's housing [mm/s^2]
  /// What is left of the displacement of a tip after its release, as a share of what it had then. @param press  with a release
  double kept_share_at(const PressPlan& press, double t_s) const;
  double stage_travel_at(double t_s) const;   ///< of the stage towards the object since the start of the run [mm]
  bool stage_commanded_at(double t_s) const;  ///< closed
};

void to_json(nlohmann::json& json, const RunPlan& plan);

struct RunPlanOptions {
  RunTimings timings;
  RunVariation variation;
  AfterEffects after;
  SpecialRuns special;
  double imu_share = 0.5;  ///< of the runs that have an IMU stream
  int run_number = 1;      ///< from 1
  bool may_be_special = false;
  std::uint64_t object_seed = 0;  ///< of what an object's runs have in common
};

/// An upper limit for the duration of a run with these options.
double longest_run_s(const RunPlanOptions& options);

/// Draws a run with `object`. Each number has a stated distribution around the object's value. So neither a region of the image
/// nor the number of events alone reveals the class.
RunPlan draw_run_plan(const ObjectModel& object, const RunPlanOptions& options, Random& random);

}  // namespace tactile::simulation
