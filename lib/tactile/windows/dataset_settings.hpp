#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/windows/write_dataset.hpp"

namespace tactile::windows {

/// The settings of a dataset, as it stores them: {"sampling": {"tick_us", …}, "mix", "include_flagged"}.
nlohmann::json dataset_settings_of(const WindowsOptions& options);

/// The same of an existing dataset. @param manifest  `Dataset::settings()`
nlohmann::json dataset_settings_in(const nlohmann::json& manifest);

/// The differences between settings as text: "seed 2 instead of 1", "history 100 ms instead of 50 ms".
std::vector<std::string> differing_settings(const nlohmann::json& now, const nlohmann::json& before);

/// The differences between `options` and the dataset in `file`; empty if there is no readable dataset.
std::vector<std::string> settings_unlike_those_in(const std::filesystem::path& file, const WindowsOptions& options);

}  // namespace tactile::windows
