#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile {

// A struct of settings names its members once, by a function beside it:
//
//   template <class Fields>
//   void list_fields(Fields& fields, RobotPhysics& robot) {
//     fields("rate_hz", robot.rate_hz, 1, 1000);             // a number and the range it must lie in
//     fields("speed_noise_mm_s", robot.speed_noise_mm_s, 0, 100);  // a Range: [low, high], both in it, low <= high
//     fields("name", robot.name);                            // text, bool, or a struct that lists its fields too
//   }
//
// and `read_fields` and `json_of_fields` do the rest.

/// Puts the members of `json` into `settings`; those that it lacks keep their values.
/// @throws Error  naming `where` and the member ("camera.threshold"): no such member (and the nearest name), of another type, or
///                out of its range
template <class Settings>
void read_fields(const nlohmann::json& json, Settings& settings, const std::string& where);

/// All members. `read_fields` of it gives the same settings.
template <class Settings>
nlohmann::json json_of_fields(const Settings& settings);

}  // namespace tactile
