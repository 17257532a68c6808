#include "tactile/detect/tick_detector.hpp"

#include <utility>

#include "tactile/core/infinite.hpp"

namespace tactile::detect {

TickDetector::TickDetector(events::SensorSize sensor, std::unique_ptr<model::EventClassifier> model,
                           const TickDetectorOptions& options)
    : sensor_(sensor), options_(options), model_(std::move(model)), decision_(options.decision, options.rendering.tick) {
  begin_ratio();
}

void TickDetector::begin_ratio() {
  ratio_.reset();
  if (options_.gate && options_.gate->ratio) ratio_.emplace(sensor_, options_.rendering.history, options_.rendering.mask);
}

TickVerdict TickDetector::verdict_at(CameraTime t, std::uint64_t skipped, TickCost& cost) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begun = Clock::now();
  model_->move_to(t);
  TickVerdict verdict{.t = t, .events = model_->events()};
  // As float32, as `eval` keeps it.
  verdict.gated = options_.gate && options_.gate->closes(verdict.events, ratio_ ? static_cast<float>(ratio_->at(t)) : infinite);
  gated_ = verdict.gated;
  if (!verdict.gated) model_->prepare();
  const Clock::time_point rendered = Clock::now();
  if (!verdict.gated) {
    const model::Logits logits = model_->classify();
    verdict.predicted = model::verdict_of(logits);
    verdict.probabilities = model::probabilities_of(logits, options_.temperature);
  }
  decision_.skip(skipped);
  verdict.verdict = decision_.next(verdict.predicted, verdict.probabilities);
  cost = {.rendering = rendered - begun, .network = Clock::now() - rendered};
  return verdict;
}

bool TickDetector::rehearse() {
  const bool closed = ratio_ ? gated_ : options_.gate && options_.gate->closes(model_->events(), infinite);
  if (closed) return false;
  model_->prepare();
  model_->classify();
  return true;
}

void TickDetector::restart() {
  model_->restart();
  decision_.restart();
  gated_ = false;
  begin_ratio();
}

}  // namespace tactile::detect
