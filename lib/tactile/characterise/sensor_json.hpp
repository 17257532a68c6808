#pragma once

#include <nlohmann/json.hpp>

#include "tactile/characterise/sensor.hpp"

namespace tactile::characterise {

/// As `sensor.json` has it; docs/format/ describes the members.
nlohmann::json json_of(const Sensor& sensor);

std::string_view name_of(UnusualPixel::Kind kind);  ///< "warm", "hot", "stuck", "lit"

}  // namespace tactile::characterise
