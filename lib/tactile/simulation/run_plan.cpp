#include "tactile/simulation/run_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactile {
namespace {

constexpr double stage_ramp_s = 0.020;
constexpr double least_closing_mm_s = 4.0, most_closing_mm_s = 20.0;  // a press of 0-2 mm done in 0.1-0.5 s

double drawn(Range range, Random& random) { return random.uniform(range.low, range.high); }

/// Round `typical`, by a factor whose logarithm is normal with this spread, cut at two spreads.
double varied(double typical, double spread, Random& random) {
  return typical * std::exp(spread * std::clamp(random.normal(), -2.0, 2.0));
}

double cut_normal(double sigma, Random& random) { return sigma * std::clamp(random.normal(), -2.5, 2.5); }

std::array<MarkerContact, marker_count> draw_contacts(const ObjectModel& object, double depth_mm, Random& random) {
  const double centre_x = cut_normal(2.5, random), centre_y = cut_normal(2.0, random);
  const double tilt_x = cut_normal(object.tilt, random), tilt_y = cut_normal(object.tilt, random);
  const double pull = random.uniform(0.8, 1.5);
  const double skid_x = cut_normal(0.25, random), skid_y = cut_normal(0.25, random);  // the stage does not push straight
  std::array<MarkerContact, marker_count> markers;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < marker_count; ++i) {
    const double dx = marker_x_mm(i) - centre_x, dy = marker_y_mm(i) - centre_y;
    const double reach = std::max(std::hypot(dx, dy), 1e-9), firm = std::min(1.0, reach / 9.0);
    MarkerContact& marker = markers[i];
    marker.gap_mm = tilt_x * dx + tilt_y * dy + cut_normal(object.irregularity_mm, random);
    if (object.radius_mm > 0) marker.gap_mm += dx * dx / (2.0 * object.radius_mm);
    // Beyond the object's edge the surface falls away steeply.
    const double beyond = std::max({0.0, std::abs(dx) - object.half_width_mm, std::abs(dy) - object.half_height_mm});
    marker.gap_mm += 2.0 * beyond;
    // A ridge that is pushed end on bends over its thin side, up or down as it happens to stand.
    marker.pull_x = -pull * firm * dx / reach + skid_x + cut_normal(0.15, random);
    marker.pull_y = -pull * firm * dy / reach + skid_y + cut_normal(0.45, random);
    marker.lag_share = random.uniform(0.0, 0.6);
    nearest = std::min(nearest, marker.gap_mm);
  }
  for (MarkerContact& marker : markers) {
    marker.gap_mm -= nearest;
    const double pressed = std::max(0.0, depth_mm - marker.gap_mm) / depth_mm;
    marker.shear_share = pressed > 0 ? (0.5 + 0.5 * pressed) * varied(1.0, 0.12, random) : 0.0;
  }
  return markers;
}

}  // namespace

void to_json(nlohmann::json& json, const RunTimings& timings) {
  const auto range = [](const Range& r) { return nlohmann::json{r.low, r.high}; };
  json = {{"quiet_s", range(timings.quiet_s)},
          {"travel_s", range(timings.travel_s)},
          {"hold_s", range(timings.hold_s)},
          {"lift_s", range(timings.lift_s)},
          {"rest_s", range(timings.rest_s)}};
}

double RunPlan::depth_at(double t_s) const {
  const double part = std::clamp((t_s - contact_s) / press_s, 0.0, 1.0);
  return depth_mm * (1.0 - std::pow(1.0 - part, press_power + 1.0));
}

double RunPlan::lift_speed_at(double t_s) const {
  const double since = t_s - lift_start_s, left = lift_s - since;
  return std::clamp(lift_acceleration_mm_s2 * std::min(since, left), 0.0, lift_speed_mm_s);
}

double RunPlan::lift_travel_at(double t_s) const {
  const double since = std::clamp(t_s - lift_start_s, 0.0, lift_s);
  const double a = lift_acceleration_mm_s2, ramp_s = lift_speed_mm_s / a;
  if (since <= ramp_s) return 0.5 * a * since * since;
  const double whole = lift_speed_mm_s * (lift_s - ramp_s);
  const double left = lift_s - since;
  if (left <= ramp_s) return whole - 0.5 * a * left * left;
  return lift_speed_mm_s * (since - 0.5 * ramp_s);
}

double RunPlan::stage_travel_at(double t_s) const {
  const double speed = closing_speed_mm_s() / stage_share;
  const double since = std::clamp(t_s, stage_start_s, contact_s) - stage_start_s;
  const double free = since < stage_ramp_s ? 0.5 * speed * since * since / stage_ramp_s : speed * (since - 0.5 * stage_ramp_s);
  return free + depth_at(t_s) / stage_share;
}

void to_json(nlohmann::json& json, const RunPlan& p) {
  nlohmann::json markers = nlohmann::json::array();
  for (const MarkerContact& m : p.markers) {
    markers.push_back({{"gap_mm", m.gap_mm},
                       {"pull_x", m.pull_x},
                       {"pull_y", m.pull_y},
                       {"shear_share", m.shear_share},
                       {"lag_share", m.lag_share}});
  }
  json = {{"stage_start_s", p.stage_start_s},
          {"contact_s", p.contact_s},
          {"press_s", p.press_s},
          {"depth_mm", p.depth_mm},
          {"press_power", p.press_power},
          {"closing_speed_mm_s", p.closing_speed_mm_s()},
          {"stage_share", p.stage_share},
          {"lift_start_s", p.lift_start_s},
          {"lift_s", p.lift_s},
          {"lift_speed_mm_s", p.lift_speed_mm_s},
          {"lift_acceleration_mm_s2", p.lift_acceleration_mm_s2},
          {"lift_angle_rad", p.lift_angle_rad},
          {"end_s", p.end_s},
          {"slack_mm", p.slack_mm},
          {"shear_limit_mm", p.shear_limit_mm},
          {"stick_slip_hz", p.stick_slip_hz},
          {"stick_slip_mm", p.stick_slip_mm},
          {"unison", p.unison},
          {"ring_hz", p.ring_hz},
          {"ring_decay_s", p.ring_decay_s},
          {"texture_mm", p.texture_mm},
          {"sink", p.sink},
          {"markers", markers},
          {"veil", p.veil},
          {"noise_factor", p.noise_factor},
          {"stage_on_robot_output", p.stage_on_robot_output}};
}

RunPlan draw_run_plan(const ObjectModel& object, const RunTimings& timings, Random& random) {
  RunPlan plan;
  plan.depth_mm = std::clamp(varied(object.depth_mm, 0.25, random), 0.4, 1.9);
  plan.press_power = random.uniform(0.6, 1.4);
  const double travel_in_units = plan.depth_mm * (plan.press_power + 1.0);
  plan.press_s = std::clamp(varied(1e-3 * object.press_ms, 0.15, random), 0.12, 0.4);
  plan.press_s = std::clamp(plan.press_s, travel_in_units / most_closing_mm_s, travel_in_units / least_closing_mm_s);
  plan.stage_share = 1.0 - object.compliance;

  plan.stage_start_s = drawn(timings.quiet_s, random);
  plan.contact_s = plan.stage_start_s + drawn(timings.travel_s, random);
  plan.lift_start_s = plan.contact_s + plan.press_s + drawn(timings.hold_s, random);
  plan.lift_s = drawn(timings.lift_s, random);
  plan.lift_speed_mm_s = random.uniform(30.0, 120.0);
  plan.lift_acceleration_mm_s2 = random.uniform(1100.0, 1300.0);
  plan.lift_angle_rad = cut_normal(0.1, random);
  plan.end_s = plan.lift_start_s + plan.lift_s + drawn(timings.rest_s, random);

  plan.slack_mm = std::clamp(varied(object.slack_mm, 0.3, random), 0.005, 0.2);
  plan.shear_limit_mm = std::clamp(varied(object.shear_limit_mm, 0.15, random), 0.2, 1.5);
  plan.stick_slip_hz = std::clamp(varied(object.stick_slip_hz, 0.15, random), 10.0, 60.0);
  plan.stick_slip_mm = std::min(varied(object.stick_slip_mm, 0.35, random), 0.8 * plan.shear_limit_mm);
  plan.unison = random.uniform(0.4, 0.9);
  plan.ring_hz = std::clamp(varied(object.ring_hz, 0.1, random), 60.0, 300.0);
  plan.ring_decay_s = 1e-3 * varied(object.ring_decay_ms, 0.15, random);
  plan.texture_mm = varied(object.texture_mm, 0.2, random);
  plan.sink = cut_normal(0.06, random);

  plan.markers = draw_contacts(object, plan.depth_mm, random);
  plan.veil = random.uniform(0.01, 0.05);
  plan.noise_factor = varied(1.0, 0.25, random);
  plan.stage_on_robot_output = random.uniform() < 0.5;
  return plan;
}

RunClocks draw_run_clocks(Random& random) {
  RunClocks clocks;
  clocks.camera_start_us = 1'700'000'000'000'000 + static_cast<std::int64_t>(random.below(50'000'000'000'000));
  // Robot log and video begin up to a second and a half before the camera; each clock counts from a start of its own.
  const auto relation = [&](std::int64_t first_stamp_us) {
    const std::int64_t first_in_camera_us = clocks.camera_start_us - 100'000 - static_cast<std::int64_t>(random.below(1'400'000));
    return ClockRelation{.offset_us = first_in_camera_us - first_stamp_us,
                         .drift_ppm = random.uniform(-100.0, 100.0),
                         .reference_us = first_stamp_us};
  };
  clocks.robot = relation(600'000'000 + static_cast<std::int64_t>(random.below(200'000'000'000)));
  clocks.video = relation(0);
  clocks.host_from_camera_us = static_cast<std::int64_t>(random.below(6'000'000)) - 3'000'000;
  return clocks;
}

RunClocks continued_clocks(const RunClocks& drawn, const RunClocks& first, CameraTime start) {
  RunClocks clocks;
  clocks.camera_start_us = us_of(start);
  clocks.host_from_camera_us = first.host_from_camera_us;
  const auto first_stamp_in_camera = [&](const ClockRelation& relation) {
    return start - (camera_time(drawn.camera_start_us) - relation.camera_from(relation.reference_us));
  };
  const CameraTime robot = first_stamp_in_camera(drawn.robot), video = first_stamp_in_camera(drawn.video);
  const std::int64_t robot_us = first.robot.clock_us_from(robot);
  clocks.robot = {.offset_us = us_of(robot) - robot_us, .drift_ppm = first.robot.drift_ppm, .reference_us = robot_us};
  clocks.video = {.offset_us = us_of(video), .drift_ppm = first.video.drift_ppm, .reference_us = 0};
  return clocks;
}

}  // namespace tactile
