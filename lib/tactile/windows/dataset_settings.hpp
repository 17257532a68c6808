#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/windows/write_dataset.hpp"

namespace tactile {

/// What a dataset is drawn by, as it keeps them: {"sampling": {"tick_us", …}, "mix", "include_flagged"}.
nlohmann::json dataset_settings_of(const WindowsOptions& options);

/// The same of a dataset that is there. @param manifest  `Dataset::settings()`
nlohmann::json dataset_settings_in(const nlohmann::json& manifest);

/// In what settings differ, for people, one each: "seed 2 instead of 1", "history 100 ms instead of 50 ms".
std::vector<std::string> differing_settings(const nlohmann::json& now, const nlohmann::json& before);

/// The same between what `options` ask for and a dataset that lies in `file`; empty where none is there that can be read.
std::vector<std::string> settings_unlike_those_in(const std::filesystem::path& file, const WindowsOptions& options);

}  // namespace tactile
