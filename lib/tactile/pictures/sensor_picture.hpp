#pragma once

#include <filesystem>

#include "tactile/characterise/sensor.hpp"

namespace tactile::pictures {

/// Draws what a sensor does: where its lines are stamped, the rates of its pixels, its unusual pixels on the sensor, and the
/// spectrum of its rate.
/// @throws Error  as `draw`
void draw_sensor(const characterise::Sensor& sensor, const std::filesystem::path& file);

}  // namespace tactile::pictures
