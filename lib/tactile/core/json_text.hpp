#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tactile {

/// JSON as text, on one line or indented. Names and paths are any bytes; what of them is no UTF-8 becomes U+FFFD.
std::string json_text(const nlohmann::json& json, int indent = -1);

}  // namespace tactile
