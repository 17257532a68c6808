#include "tactile/model/inference/tree_classifier.hpp"

#include <fmt/core.h>

#include <utility>

#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

features::SlidingSums sums_of(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering) {
  return {sensor, rendering.history, features::bin_of(rendering.tick, rendering.history), rendering.mask};
}

}  // namespace

TreeClassifier::TreeClassifier(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering,
                               std::shared_ptr<const BoostedTrees> trees)
    : sensor_(sensor), rendering_(rendering), trees_(std::move(trees)), sums_(sums_of(sensor, rendering)) {
  if (trees_->features() != features::feature_count)
    throw Error(fmt::format("trees that read {} features; expected {}", trees_->features(), features::feature_count));
}

void TreeClassifier::restart() { sums_ = sums_of(sensor_, rendering_); }

}  // namespace tactile::model
