#pragma once

#include <memory>

#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/inference/event_classifier.hpp"
#include "tactile/model/inference/temporal_network.hpp"

namespace tactile::model {

/// A temporal convolution, with the features that it reads.
class TemporalClassifier final : public EventClassifier {
 public:
  /// @param rendering  its history, tick and mask are used; ticks are whole multiples of the tick
  /// @param step       between the steps that the network reads: the tick of its training
  /// @throws Error  as `features::step_windows`
  TemporalClassifier(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering, microseconds step,
                     std::shared_ptr<const TemporalNetwork> network);

  void add(std::span<const events::Event> events) override { features_.add(events); }
  void move_to(CameraTime tick) override { features_.move_to(tick); }
  std::uint64_t events() const override { return features_.events(); }
  void prepare() override { input_ = features_.features(); }
  Logits classify() override { return network_->logits(input_); }
  void restart() override;

 private:
  events::SensorSize sensor_;
  heatmaps::HeatmapOptions rendering_;
  features::StepWindows windows_;
  std::shared_ptr<const TemporalNetwork> network_;
  features::StepFeatures features_;
  std::array<float, features::step_values> input_{};
};

}  // namespace tactile::model
