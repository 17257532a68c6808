#include "tactile/core/changed_values.hpp"

#include <algorithm>

namespace tactile {

std::vector<ChangedValue> changed_values(const nlohmann::json& before, const nlohmann::json& now) {
  const nlohmann::json flat_before = before.flatten(), flat_now = now.flatten();
  nlohmann::json paths = flat_before;
  paths.update(flat_now);
  std::vector<ChangedValue> changed;
  for (const auto& [path, any] : paths.items()) {
    ChangedValue value{path.substr(std::min<std::size_t>(1, path.size())), flat_before.value(path, nlohmann::json()),
                       flat_now.value(path, nlohmann::json())};
    if (flat_before.contains(path) && flat_now.contains(path) && value.before == value.now) continue;
    std::replace(value.path.begin(), value.path.end(), '/', '.');
    changed.push_back(std::move(value));
  }
  return changed;
}

}  // namespace tactile
