#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace tactile {

/// @param subject   begins the sentence: "data/fan/01/labels.json:", or "model.json: 'split'"
/// @param contents  what the object has: " with the run's members"
/// @throws Error  "SUBJECT is a list; expected an object", unless it is an object
void check_object(const nlohmann::json& json, std::string_view subject, std::string_view contents = "");

}  // namespace tactile
