#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/windows/dataset.hpp"

// Names and rules for both reading and writing a dataset.
namespace tactile::windows::dataset_layout {

inline constexpr std::int64_t format = 1;

/// Group of a file of heatmaps: `sha256` and `samples` of each run with samples, in their order (`source_sha256_of`).
inline constexpr const char* sources = "sources";

/// "dataset.h5" -> "dataset.events.h5", "dataset.th_040.h5", next to it.
inline std::filesystem::path file_beside(const std::filesystem::path& dataset, const std::string& part) {
  return dataset.parent_path() / (dataset.stem().string() + "." + part + ".h5");
}

/// The manifest, whose hash identifies a dataset. `settings` = sampling options, mix, include_flagged.
nlohmann::json manifest_of(const nlohmann::json& settings, events::SensorSize sensor, bool simulated,
                           std::span<const DatasetRun> runs);

/// To lock while files of a dataset are replaced, so that only one process does.
inline std::filesystem::path folder_of(const std::filesystem::path& dataset) {
  return dataset.has_parent_path() ? dataset.parent_path() : std::filesystem::path(".");
}

}  // namespace tactile::windows::dataset_layout
