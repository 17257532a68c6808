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

/// "dataset.h5" -> "dataset.events.h5", "dataset.th_040.h5", next to it.
inline std::filesystem::path file_beside(const std::filesystem::path& dataset, const std::string& part) {
  return dataset.parent_path() / (dataset.stem().string() + "." + part + ".h5");
}

/// The manifest, whose hash identifies a dataset. `settings` = sampling options, mix, include_flagged.
nlohmann::json manifest_of(const nlohmann::json& settings, events::SensorSize sensor, bool simulated,
                           std::span<const DatasetRun> runs);

/// Locks the folder of a dataset, so that only one process replaces files in it.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& dataset);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int folder_ = -1;
};

}  // namespace tactile::windows::dataset_layout
