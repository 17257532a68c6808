#include "tactile/windows/dataset_layout.hpp"

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

}  // namespace tactile::windows::dataset_layout
