#include "tactile/detect/tick_detector.hpp"

#include <fmt/core.h>

#include <utility>

#include "tactile/core/error.hpp"

namespace tactile::detect {

TickDetector::TickDetector(events::SensorSize sensor, events::SensorSize input, ClassifyHeatmap classify,
                           const TickDetectorOptions& options)
    : sensor_(sensor),
      options_(options),
      classify_(std::move(classify)),
      renderer_(sensor, options.rendering),
      decision_(options.decision, options.rendering.tick),
      heatmap_(static_cast<std::size_t>(renderer_.size().width) * static_cast<std::size_t>(renderer_.size().height)) {
  if (renderer_.size() == input) return;
  throw Error(fmt::format("the sensor's heatmaps are {} x {} cells; expected the {} x {} that the model was trained on",
                          renderer_.size().width, renderer_.size().height, input.width, input.height));
}

TickVerdict TickDetector::verdict_at(CameraTime t, std::uint64_t skipped, TickCost& cost) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begun = Clock::now();
  renderer_.move_to(t);
  TickVerdict verdict{.t = t, .events = renderer_.events()};
  verdict.gated = options_.gate && verdict.events < *options_.gate;
  if (!verdict.gated) renderer_.render(std::span(heatmap_));
  const Clock::time_point rendered = Clock::now();
  if (!verdict.gated) {
    const model::Logits logits = classify_(heatmap_);
    verdict.predicted = model::verdict_of(logits);
    verdict.probabilities = model::probabilities_of(logits, options_.temperature);
  }
  decision_.skip(skipped);
  verdict.verdict = decision_.next(verdict.predicted, verdict.probabilities);
  cost = {.rendering = rendered - begun, .network = Clock::now() - rendered};
  return verdict;
}

bool TickDetector::rehearse() {
  if (options_.gate && renderer_.events() < *options_.gate) return false;
  renderer_.render(std::span(heatmap_));
  classify_(heatmap_);
  return true;
}

void TickDetector::restart() {
  renderer_ = heatmaps::HeatmapRenderer(sensor_, options_.rendering);
  decision_.restart();
}

}  // namespace tactile::detect
