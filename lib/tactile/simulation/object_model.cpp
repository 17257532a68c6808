#include "tactile/simulation/object_model.hpp"

#include <vector>

#include "tactile/core/error.hpp"

namespace tactile {

void to_json(nlohmann::json& json, const ObjectModel& o) {
  json = {{"name", o.name},
          {"radius_mm", o.radius_mm},
          {"half_width_mm", o.half_width_mm},
          {"half_height_mm", o.half_height_mm},
          {"irregularity_mm", o.irregularity_mm},
          {"tilt", o.tilt},
          {"compliance", o.compliance},
          {"depth_mm", o.depth_mm},
          {"press_ms", o.press_ms},
          {"slack_mm", o.slack_mm},
          {"shear_limit_mm", o.shear_limit_mm},
          {"stick_slip_hz", o.stick_slip_hz},
          {"stick_slip_mm", o.stick_slip_mm},
          {"ring_hz", o.ring_hz},
          {"ring_decay_ms", o.ring_decay_ms},
          {"texture_mm", o.texture_mm}};
}

std::span<const ObjectModel> object_models() {
  static const std::vector<ObjectModel> models{
      {.name = "3d-printed-object",
       .why = "Hard, with a bumpy surface whose layer lines make the tips tremble.",
       .irregularity_mm = 0.30, .tilt = 0.012, .compliance = 0.0, .depth_mm = 0.95, .press_ms = 200, .slack_mm = 0.04,
       .shear_limit_mm = 0.55, .stick_slip_hz = 38, .stick_slip_mm = 0.085, .ring_hz = 180, .ring_decay_ms = 6, .texture_mm = 0.012},
      {.name = "uhu-glue-stick",
       .why = "A thin, smooth cylinder: only the column of markers in front of it is touched, and glossy plastic slips early.",
       .radius_mm = 11, .half_width_mm = 8, .half_height_mm = 15, .irregularity_mm = 0.02, .tilt = 0.01, .compliance = 0.05, .depth_mm = 1.0,
       .press_ms = 190, .slack_mm = 0.05, .shear_limit_mm = 0.42, .stick_slip_hz = 24, .stick_slip_mm = 0.15, .ring_hz = 150,
       .ring_decay_ms = 8, .texture_mm = 0.003},
      {.name = "sprayer",
       .why = "A bottle with a half-soft wall and a waist: it gives a little, and the wall swings with the slips.",
       .radius_mm = 75, .half_width_mm = 20, .half_height_mm = 15, .irregularity_mm = 0.10, .tilt = 0.025, .compliance = 0.30, .depth_mm = 1.05,
       .press_ms = 270, .slack_mm = 0.08, .shear_limit_mm = 0.8, .stick_slip_hz = 19, .stick_slip_mm = 0.14, .ring_hz = 110,
       .ring_decay_ms = 10, .texture_mm = 0.005},
      {.name = "water-bottle",
       .why = "A thin wall that flattens against the skin: slow, even contact, long shear and slow, wide stick-slip.",
       .radius_mm = 110, .half_width_mm = 20, .half_height_mm = 15, .irregularity_mm = 0.06, .tilt = 0.012, .compliance = 0.50, .depth_mm = 1.1,
       .press_ms = 320, .slack_mm = 0.10, .shear_limit_mm = 1.1, .stick_slip_hz = 14, .stick_slip_mm = 0.17, .ring_hz = 85,
       .ring_decay_ms = 12, .texture_mm = 0.004},
      {.name = "fan",
       .why = "A stiff grille: its ribs touch some markers well before others, and it rings fast.",
       .half_width_mm = 20, .half_height_mm = 14, .irregularity_mm = 0.25, .tilt = 0.015, .compliance = 0.10, .depth_mm = 0.85, .press_ms = 170,
       .slack_mm = 0.03, .shear_limit_mm = 0.5, .stick_slip_hz = 46, .stick_slip_mm = 0.07, .ring_hz = 250, .ring_decay_ms = 5,
       .texture_mm = 0.008},
      {.name = "white-box",
       .why = "Flat, smooth cardboard: nearly all markers touch at once.",
       .irregularity_mm = 0.03, .tilt = 0.012, .compliance = 0.15, .depth_mm = 0.7, .press_ms = 230, .slack_mm = 0.05, .shear_limit_mm = 0.5,
       .stick_slip_hz = 28, .stick_slip_mm = 0.09, .ring_hz = 140, .ring_decay_ms = 7, .texture_mm = 0.004},
      {.name = "textured-box",
       .why = "Flat but rough: high friction drags the tips far, and the relief shakes them finely rather than in jerks.",
       .irregularity_mm = 0.08, .tilt = 0.012, .compliance = 0.15, .depth_mm = 0.75, .press_ms = 240, .slack_mm = 0.04, .shear_limit_mm = 1.25,
       .stick_slip_hz = 54, .stick_slip_mm = 0.05, .ring_hz = 210, .ring_decay_ms = 5, .texture_mm = 0.025},
      {.name = "plastic-container",
       .why = "Thin ribbed walls that buckle: contact comes piece by piece, and it slips early, slowly and in wide swings.",
       .half_width_mm = 18, .half_height_mm = 13, .irregularity_mm = 0.55, .tilt = 0.035, .compliance = 0.55, .depth_mm = 1.5, .press_ms = 360,
       .slack_mm = 0.14, .shear_limit_mm = 0.3, .stick_slip_hz = 11, .stick_slip_mm = 0.22, .ring_hz = 65, .ring_decay_ms = 14,
       .texture_mm = 0.006},
      {.name = "small-box",
       .why = "Smaller than the skin: only a few neighbouring markers are touched, by flat, stiff cardboard.",
       .half_width_mm = 13, .half_height_mm = 9.5, .irregularity_mm = 0.04, .tilt = 0.02, .compliance = 0.10, .depth_mm = 1.0, .press_ms = 210,
       .slack_mm = 0.05, .shear_limit_mm = 0.6, .stick_slip_hz = 33, .stick_slip_mm = 0.11, .ring_hz = 160, .ring_decay_ms = 7,
       .texture_mm = 0.005},
      {.name = "usb-hub",
       .why = "Long, low and hard, with sockets: one row of markers or two, little shear and a high, dry ring.",
       .half_width_mm = 20, .half_height_mm = 7, .irregularity_mm = 0.12, .tilt = 0.015, .compliance = 0.0, .depth_mm = 0.95, .press_ms = 160,
       .slack_mm = 0.02, .shear_limit_mm = 0.35, .stick_slip_hz = 42, .stick_slip_mm = 0.12, .ring_hz = 290, .ring_decay_ms = 4,
       .texture_mm = 0.006},
  };
  return models;
}

const ObjectModel& object_model(std::string_view name) {
  std::string names;
  for (const ObjectModel& object : object_models()) {
    if (object.name == name) return object;
    names += (names.empty() ? "" : ", ") + object.name;
  }
  throw Error("'" + std::string(name) + "' is no object that can be simulated; expected one of " + names);
}

}  // namespace tactile
