#include "tactile/detect/tick_detector.hpp"

#include <fmt/core.h>

#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/infinite.hpp"

namespace tactile::detect {

TickDetector::TickDetector(events::SensorSize sensor, events::SensorSize input, ClassifyHeatmap classify,
                           const TickDetectorOptions& options)
    : sensor_(sensor),
      options_(options),
      classify_(std::move(classify)),
      renderer_(sensor, options.rendering),
      decision_(options.decision, options.rendering.tick),
      heatmap_(static_cast<std::size_t>(renderer_.size().width) * static_cast<std::size_t>(renderer_.size().height)) {
  begin_ratio();
  if (renderer_.size() == input) return;
  throw Error(fmt::format("the sensor's heatmaps are {} x {} cells; expected the {} x {} that the model was trained on",
                          renderer_.size().width, renderer_.size().height, input.width, input.height));
}

void TickDetector::begin_ratio() {
  ratio_.reset();
  if (options_.gate && options_.gate->ratio) ratio_.emplace(sensor_, options_.rendering.history, options_.rendering.mask);
}

TickVerdict TickDetector::verdict_at(CameraTime t, std::uint64_t skipped, TickCost& cost) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begun = Clock::now();
  renderer_.move_to(t);
  TickVerdict verdict{.t = t, .events = renderer_.events()};
  // As float32, as `eval` keeps it.
  verdict.gated = options_.gate && options_.gate->closes(verdict.events, ratio_ ? static_cast<float>(ratio_->at(t)) : infinite);
  gated_ = verdict.gated;
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
  const bool closed = ratio_ ? gated_ : options_.gate && options_.gate->closes(renderer_.events(), infinite);
  if (closed) return false;
  renderer_.render(std::span(heatmap_));
  classify_(heatmap_);
  return true;
}

void TickDetector::restart() {
  renderer_ = heatmaps::HeatmapRenderer(sensor_, options_.rendering);
  decision_.restart();
  gated_ = false;
  begin_ratio();
}

}  // namespace tactile::detect
