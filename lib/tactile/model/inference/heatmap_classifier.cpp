#include "tactile/model/inference/heatmap_classifier.hpp"

#include <utility>

namespace tactile::model {

HeatmapClassifier::HeatmapClassifier(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering,
                                     ClassifyHeatmap network)
    : sensor_(sensor),
      renderer_(sensor, rendering),
      network_(std::move(network)),
      heatmap_(static_cast<std::size_t>(renderer_.size().width) * static_cast<std::size_t>(renderer_.size().height)) {}

}  // namespace tactile::model
