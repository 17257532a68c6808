#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tactile {

/// A value that differs between two JSON documents; null where a document lacks it.
struct ChangedValue {
  std::string path;  ///< "training.epochs", "list.2"
  nlohmann::json before, now;
};

/// The values that differ, by path. Empty lists and objects are null; one that only one document has is listed too.
std::vector<ChangedValue> changed_values(const nlohmann::json& before, const nlohmann::json& now);

}  // namespace tactile
