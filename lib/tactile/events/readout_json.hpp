#pragma once

#include <nlohmann/json.hpp>

#include "tactile/events/readout.hpp"

namespace tactile::events {

/// `{"value": v, "uncertainty": u}`; null for what is not finite.
nlohmann::json json_of(const Measured& measured);

/// As `sensor.json` and `info --json` have it; docs/format/ describes the members.
nlohmann::json json_of(const Readout& readout);

std::string_view name_of(Scan scan);           ///< "none", "columns", "rows"
std::string_view name_of(Readout::Kind kind);  ///< "none", "unsteady", "steady"

}  // namespace tactile::events
