#pragma once

#include <functional>
#include <vector>

#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/inference/event_classifier.hpp"

namespace tactile::model {

/// The logits of one heatmap. Of one thread.
using ClassifyHeatmap = std::function<Logits(std::span<const std::uint8_t> heatmap)>;

/// A network that reads heatmaps, with the renderer that makes them.
class HeatmapClassifier final : public EventClassifier {
 public:
  /// @throws Error  as HeatmapRenderer
  HeatmapClassifier(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering, ClassifyHeatmap network);

  void add(std::span<const events::Event> events) override { renderer_.add(events); }
  void move_to(CameraTime tick) override { renderer_.move_to(tick); }
  std::uint64_t events() const override { return renderer_.events(); }
  void prepare() override { renderer_.render(std::span(heatmap_)); }
  Logits classify() override { return network_(heatmap_); }
  void restart() override { renderer_ = heatmaps::HeatmapRenderer(sensor_, renderer_.options()); }

 private:
  events::SensorSize sensor_;
  heatmaps::HeatmapRenderer renderer_;
  ClassifyHeatmap network_;
  std::vector<std::uint8_t> heatmap_;
};

}  // namespace tactile::model
