#include "tactile/simulation/run_plan.hpp"

namespace tactile::simulation {
namespace {

nlohmann::json json_of(const MarkerContact& m) {
  return {{"gap_mm", m.gap_mm},
          {"pull_x", m.pull_x},
          {"pull_y", m.pull_y},
          {"shear_share", m.shear_share},
          {"lag_share", m.lag_share}};
}

nlohmann::json json_of(const PressPlan& p) {
  nlohmann::json markers = nlohmann::json::array();
  for (const MarkerContact& marker : p.markers) markers.push_back(json_of(marker));
  nlohmann::json json = {{"stage_start_s", p.stage_start_s},
                         {"contact_s", p.contact_s},
                         {"press_s", p.press_s},
                         {"depth_mm", p.depth_mm},
                         {"press_power", p.press_power},
                         {"closing_speed_mm_s", p.closing_speed_mm_s()},
                         {"stage_share", p.stage_share},
                         {"relaxation_share", p.relaxation_share},
                         {"relaxation_s", p.relaxation_s},
                         {"release_start_s", nullptr},
                         {"markers", markers}};
  if (p.release_start_s) {
    json["release_start_s"] = *p.release_start_s;
    json["release_s"] = p.release_s;
  }
  return json;
}

nlohmann::json json_of(const LiftPlan& l) {
  return {{"start_s", l.start_s},
          {"lift_s", l.lift_s},
          {"speed_mm_s", l.speed_mm_s},
          {"acceleration_mm_s2", l.acceleration_mm_s2},
          {"angle_rad", l.angle_rad},
          {"slack_mm", l.slack_mm},
          {"shear_limit_mm", l.shear_limit_mm},
          {"stick_slip_hz", l.stick_slip_hz},
          {"stick_slip_mm", l.stick_slip_mm},
          {"unison", l.unison},
          {"stick_slip_jitter", l.stick_slip_jitter},
          {"spring_back_jitter", l.spring_back_jitter},
          {"limit_jitter", l.limit_jitter},
          {"ring_hz", l.ring_hz},
          {"ring_decay_s", l.ring_decay_s},
          {"texture_mm", l.texture_mm},
          {"texture_memory_s", l.texture_memory_s},
          {"sink", l.sink},
          {"firm_mm", l.firm_mm}};
}

}  // namespace

void to_json(nlohmann::json& json, const RunPlan& p) {
  nlohmann::json presses = nlohmann::json::array(), taps = presses, micro_slips = presses, recontacts = presses, turns = presses;
  for (const PressPlan& press : p.presses) presses.push_back(json_of(press));
  for (const TapPlan& tap : p.taps) {
    taps.push_back({{"start_s", tap.start_s}, {"travel_mm", tap.travel_mm}, {"tap_s", tap.tap_s}, {"depth_mm", tap.depth_mm}});
  }
  for (const MicroSlipPlan& slip : p.micro_slips) {
    nlohmann::json markers = nlohmann::json::array();
    for (std::size_t m = 0; m < marker_count; ++m) {
      if ((slip.markers >> m & 1U) != 0) markers.push_back(m);
    }
    micro_slips.push_back({{"at_s", slip.at_s},
                           {"slip_s", slip.slip_s},
                           {"markers", markers},
                           {"slip_mm", slip.slip_mm},
                           {"ring_hz", slip.ring_hz},
                           {"ring_decay_s", slip.ring_decay_s}});
  }
  for (const RecontactPlan& rocks : p.recontacts) {
    recontacts.push_back({{"start_s", rocks.start_s}, {"recontact_s", rocks.recontact_s}, {"depth_mm", rocks.depth_mm}});
  }
  for (const TurnPlan& turn : p.turns)
    turns.push_back({{"start_s", turn.start_s}, {"turn_s", turn.turn_s}, {"angle_rad", turn.angle_rad}});
  json = {
      {"presses", presses},
      {"lift", p.lift ? json_of(*p.lift) : nlohmann::json()},
      {"taps", taps},
      {"micro_slips", micro_slips},
      {"recontacts", recontacts},
      {"turns", turns},
      {"hysteresis_share", p.hysteresis_share},
      {"hysteresis_s", p.hysteresis_s},
      {"light_drift",
       {{"amplitude", p.light_drift.amplitude}, {"period_s", p.light_drift.period_s}, {"phase_rad", p.light_drift.phase_rad}}},
      {"vibration",
       {{"hz", p.vibration.hz},
        {"tip_mm", p.vibration.tip_mm},
        {"decay_s", p.vibration.decay_s},
        {"housing_share", p.vibration.housing_share}}},
      {"end_s", p.end_s},
      {"skin_coupling", p.skin_coupling},
      {"veil", p.veil},
      {"noise_factor", p.noise_factor},
      {"stage_on_robot_output", p.stage_on_robot_output},
      {"has_imu", p.has_imu}};
}

}  // namespace tactile::simulation
