#include "tactile/model/inference/own_classifier.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/inference/heatmap_classifier.hpp"
#include "tactile/model/inference/stream_counts.hpp"
#include "tactile/model/inference/tick_classifier.hpp"

namespace tactile::model {
namespace {

void fill(std::span<const std::uint8_t> heatmap, std::span<float> input) {
  std::transform(heatmap.begin(), heatmap.end(), input.begin(),
                 [](std::uint8_t cell) { return static_cast<float>(cell) / 255.0F; });
}

class OwnHeatmapTicks final : public TickClassifier {
 public:
  OwnHeatmapTicks(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering, OwnTicks network)
      : TickClassifier(sensor, rendering.tick, rendering.mask),
        sensor_(sensor),
        renderer_(sensor, rendering),
        network_(std::move(network)),
        heatmap_(network_.input().size()) {}

  std::uint64_t events() const override { return renderer_.events(); }

 private:
  Logits advance(std::span<const events::Event> of_tick, CameraTime tick) override {
    renderer_.add(of_tick);
    renderer_.move_to(tick);
    renderer_.render(std::span(heatmap_));
    fill(heatmap_, network_.input());
    return network_.advance();
  }

  void forget() override {
    renderer_ = heatmaps::HeatmapRenderer(sensor_, renderer_.options());
    network_.restart();
  }

  events::SensorSize sensor_;
  heatmaps::HeatmapRenderer renderer_;
  OwnTicks network_;
  std::vector<std::uint8_t> heatmap_;
};

class OwnCountTicks final : public TickClassifier {
 public:
  OwnCountTicks(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering, const StreamGrid& grid, OwnTicks network)
      : TickClassifier(sensor, rendering.tick, rendering.mask), counts_(sensor, grid), network_(std::move(network)) {}

  std::uint64_t events() const override { return events_; }  ///< of the last tick

 private:
  Logits advance(std::span<const events::Event> of_tick, CameraTime) override {
    const std::span<float> input = network_.input();
    for (const std::uint16_t cell : counts_.touched()) input[cell] = 0;
    counts_.clear();
    for (const events::Event& event : of_tick) counts_.count(event);
    for (const std::uint16_t cell : counts_.touched()) input[cell] = static_cast<float>(counts_.at(cell));
    events_ = of_tick.size();
    return network_.advance();
  }

  void forget() override {
    counts_.clear();
    network_.restart();
    events_ = 0;
  }

  StreamCounts counts_;
  OwnTicks network_;
  std::uint64_t events_ = 0;
};

}  // namespace

std::unique_ptr<EventClassifier> own_classifier(const std::string& file, const OwnDescription& description,
                                                events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering,
                                                std::unique_ptr<OwnNetwork> network) {
  OwnTicks ticks(file, ports_of(description), std::move(network));
  if (description.input == OwnInput::heatmap && description.states.empty()) {
    const auto shared = std::make_shared<OwnTicks>(std::move(ticks));
    return std::make_unique<HeatmapClassifier>(sensor, rendering, [shared](std::span<const std::uint8_t> heatmap) {
      fill(heatmap, shared->input());
      return shared->advance();
    });
  }
  if (const microseconds own = description.rendering.tick; rendering.tick != own)
    throw Error(fmt::format("a tick of {} us; expected the {} us by which {} counts", rendering.tick.count(), own.count(), file));
  if (description.input == OwnInput::heatmap) return std::make_unique<OwnHeatmapTicks>(sensor, rendering, std::move(ticks));
  const auto& [left, top, right, bottom] = description.grid;
  return std::make_unique<OwnCountTicks>(sensor, rendering, StreamGrid{left, top, right, bottom}, std::move(ticks));
}

}  // namespace tactile::model
