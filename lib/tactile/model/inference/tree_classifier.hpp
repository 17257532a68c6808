#pragma once

#include <memory>

#include "tactile/features/tick_features.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/inference/boosted_trees.hpp"
#include "tactile/model/inference/event_classifier.hpp"

namespace tactile::model {

/// Trees on `features::TickFeatures`, with the sums that these are made from.
class TreeClassifier final : public EventClassifier {
 public:
  /// @param rendering  its history, tick and mask are used; ticks are whole multiples of the tick
  /// @throws Error  as `features::bin_of`, or if the trees read another number of features
  TreeClassifier(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering, std::shared_ptr<const BoostedTrees> trees);

  void add(std::span<const events::Event> events) override { sums_.add(events); }
  void move_to(CameraTime tick) override { sums_.move_to(tick); }
  std::uint64_t events() const override { return sums_.events(); }
  void prepare() override { features_ = features::tick_features(sums_, sensor_); }
  Logits classify() override { return trees_->logits(features_); }
  void restart() override;

 private:
  events::SensorSize sensor_;
  heatmaps::HeatmapOptions rendering_;
  std::shared_ptr<const BoostedTrees> trees_;
  features::SlidingSums sums_;
  features::TickFeatures features_{};
};

}  // namespace tactile::model
