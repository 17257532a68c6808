#include "tactile/windows/dataset_layout.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace tactile::windows::dataset_layout {

nlohmann::json manifest_of(const nlohmann::json& settings, events::SensorSize sensor, bool simulated,
                           std::span<const DatasetRun> runs) {
  nlohmann::json manifest = settings;
  manifest["format"] = format;
  manifest["sensor"] = {{"width", sensor.width}, {"height", sensor.height}};
  manifest["simulated"] = simulated;
  manifest["runs"] = nlohmann::json::array();
  for (const DatasetRun& run : runs) {
    manifest["runs"].push_back(
        {{"object", run.object}, {"run", run.run}, {"events_sha256", run.events_sha256}, {"labels_sha256", run.labels_sha256}});
  }
  return manifest;
}

FolderLock::FolderLock(const std::filesystem::path& dataset) {
  const std::filesystem::path folder = dataset.has_parent_path() ? dataset.parent_path() : std::filesystem::path(".");
  folder_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // Some network disks cannot lock folders. Then one of two simultaneous commands may lose its link, and its file is made again.
  if (folder_ >= 0) (void)::flock(folder_, LOCK_EX);
}

FolderLock::~FolderLock() {
  if (folder_ >= 0) ::close(folder_);
}

}  // namespace tactile::windows::dataset_layout
