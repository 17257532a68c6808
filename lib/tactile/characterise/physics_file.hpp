#pragma once

#include <nlohmann/json.hpp>

#include "tactile/characterise/sensor.hpp"

namespace tactile::characterise {

/// The measured values as a file for `tactile simulate --physics`: the noise, the unusual pixels and the read-out of the camera,
/// which is the same in all sessions. What was not measured (contrast threshold, optics, light) stays as the simulator has it.
/// A jitter or wander below twice its uncertainty is 0, and so are dead pixels. Flicker is not in it: the depth of the event rate
/// does not show that of the light.
nlohmann::json physics_of(const Sensor& sensor);

}  // namespace tactile::characterise
