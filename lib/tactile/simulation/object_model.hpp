#pragma once

#include <string>

namespace tactile::simulation {

/// The properties of an object under the sensor. They are typical values, around which each run varies. configs/objects.json has
/// the paper's ten objects. Their numbers are chosen, not measured: they are within the ranges reported for slip sensing
/// (stick-slip of 10-60 Hz, ringing of 60-300 Hz, shear of 0.2-1.5 mm) and spread the objects over them.
struct ObjectModel {
  std::string name;
  std::string why;              ///< one sentence: the reason for these numbers
  double radius_mm = 0;         ///< of an upright cylinder; 0: flat
  double half_width_mm = 20;    ///< of the area that can touch, across
  double half_height_mm = 15;   ///< the same, along the lift
  double irregularity_mm = 0;   ///< standard deviation of the surface under a marker
  double tilt = 0.01;           ///< standard deviation of its gradient against the skin [mm per mm]
  double compliance = 0;        ///< share of the stage's travel by which the object yields, in [0, 1)
  double depth_mm = 0.8;        ///< of the first marker
  double press_ms = 220;        ///< from contact until the stage is still
  double slack_mm = 0.05;       ///< lift before it moves the tips
  double shear_limit_mm = 0.6;  ///< by which a tip is dragged before it slips: friction / stiffness
  double stick_slip_hz = 30;
  double stick_slip_mm = 0.1;  ///< by which a tip springs back at each slip
  double ring_hz = 150;        ///< of the tip after a slip
  double ring_decay_ms = 7;
  double texture_mm = 0.005;  ///< standard deviation of the tip's tremble while the surface slides
  double reflectivity = 0.6;  ///< share of the light that it reflects: its grey in the film
  double weight_g = 100;
};

template <class Fields>
void list_fields(Fields& fields, ObjectModel& o) {
  fields("name", o.name);
  fields("why", o.why);
  fields("radius_mm", o.radius_mm, 0, 1000);
  fields("half_width_mm", o.half_width_mm, 1, 200);
  fields("half_height_mm", o.half_height_mm, 1, 200);
  fields("irregularity_mm", o.irregularity_mm, 0, 5);
  fields("tilt", o.tilt, 0, 0.5);
  fields("compliance", o.compliance, 0, 0.95);
  fields("depth_mm", o.depth_mm, 0.05, 5);
  fields("press_ms", o.press_ms, 10, 5000);
  fields("slack_mm", o.slack_mm, 0, 5);
  fields("shear_limit_mm", o.shear_limit_mm, 0.01, 5);
  fields("stick_slip_hz", o.stick_slip_hz, 1, 200);
  fields("stick_slip_mm", o.stick_slip_mm, 0, 2);
  fields("ring_hz", o.ring_hz, 10, 1000);
  fields("ring_decay_ms", o.ring_decay_ms, 0.1, 1000);
  fields("texture_mm", o.texture_mm, 0, 0.5);
  fields("reflectivity", o.reflectivity, 0, 1);
  fields("weight_g", o.weight_g, 0, 10'000);
}

}  // namespace tactile::simulation
