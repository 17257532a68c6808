#include "tactile/windows/dataset_settings.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <string_view>

#include "tactile/core/changed_values.hpp"
#include "tactile/core/error.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::windows {
namespace {

std::string text_of(std::string_view key, const nlohmann::json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "on" : "off";
  if (key.ends_with("_us") && value.is_number()) return fmt::format("{:g} ms", value.get<double>() / 1000);
  return value.is_null() ? "none" : value.dump();
}

std::string name_of(std::string_view key) {
  std::string name(key.substr(0, key.size() - (key.ends_with("_us") ? 3 : 0)));
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

/// All keys on one level.
nlohmann::json flat(const nlohmann::json& settings) {
  nlohmann::json all = nlohmann::json::object();
  for (const auto& [key, value] : settings.items()) {
    if (value.is_object())
      all.update(value);
    else
      all[key] = value;
  }
  return all;
}

}  // namespace

nlohmann::json dataset_settings_of(const WindowsOptions& options) {
  return {{"sampling", json_of_fields(options.sampling)}, {"mix", options.mix}, {"include_flagged", options.include_flagged}};
}

nlohmann::json dataset_settings_in(const nlohmann::json& manifest) {
  nlohmann::json settings = nlohmann::json::object();
  for (const char* key : {"sampling", "mix", "include_flagged"}) {
    if (manifest.contains(key)) settings[key] = manifest.at(key);
  }
  return settings;
}

std::vector<std::string> differing_settings(const nlohmann::json& now, const nlohmann::json& before) {
  const nlohmann::json all = flat(now);
  std::vector<std::string> differing;
  for (const ChangedValue& changed : changed_values(flat(before), all)) {
    const std::string& key = changed.path;
    if (all.contains(key) && changed.now != changed.before)
      differing.push_back(
          fmt::format("{} {} instead of {}", name_of(key), text_of(key, changed.now), text_of(key, changed.before)));
  }
  return differing;
}

std::vector<std::string> settings_unlike_those_in(const std::filesystem::path& file, const WindowsOptions& options) {
  if (!std::filesystem::exists(file)) return {};
  try {
    return differing_settings(dataset_settings_of(options), dataset_settings_in(Dataset(file).settings()));
  } catch (const Error&) {
    return {};
  }
}

}  // namespace tactile::windows
