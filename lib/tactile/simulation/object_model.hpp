#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

namespace tactile {

/// What sets one object apart from another under the sensor. Typical values: each run varies round them.
struct ObjectModel {
  std::string name;
  std::string why;              ///< one sentence: what about the object makes its numbers so
  double radius_mm = 0;         ///< of an upright cylinder; 0 where it is flat
  double half_width_mm = 20;    ///< of the area that can touch, across
  double half_height_mm = 15;   ///< and along the lift
  double irregularity_mm = 0;   ///< standard deviation of the surface under a marker
  double tilt = 0.01;           ///< standard deviation of its slope against the skin [mm per mm]
  double compliance = 0;        ///< share of the stage's travel by which the object gives way, 0 to below 1
  double depth_mm = 0.8;        ///< how far the first marker is pushed in
  double press_ms = 220;        ///< from contact to standing still
  double slack_mm = 0.05;       ///< lift before the tips feel it
  double shear_limit_mm = 0.6;  ///< how far a tip is dragged along before it slips: friction over stiffness
  double stick_slip_hz = 30;
  double stick_slip_mm = 0.1;  ///< by how much a tip springs back at each slip
  double ring_hz = 150;        ///< of the tip after it
  double ring_decay_ms = 7;
  double texture_mm = 0.005;  ///< standard deviation of the tip's tremble while the surface runs past
};

void to_json(nlohmann::json& json, const ObjectModel& object);

/// The paper's ten, in its order (Faris et al., arXiv:2403.10120, figure 6). Their numbers are chosen, not measured: they keep
/// within what slip sensing reports (stick-slip of 10-60 Hz, ringing of 60-300 Hz, shear of 0.2-1.5 mm) and spread the objects
/// over it.
std::span<const ObjectModel> object_models();

/// @throws Error that lists them if no object has this name
const ObjectModel& object_model(std::string_view name);

}  // namespace tactile
