#include "tactile/detect/tick_detector.hpp"

#include <utility>

namespace tactile::detect {

TickDetector::TickDetector(std::unique_ptr<model::EventClassifier> model, const TickDetectorOptions& options)
    : temperature_(options.temperature), model_(std::move(model)), decision_(options.decision, options.rendering.tick) {}

TickVerdict TickDetector::verdict_at(CameraTime t, std::uint64_t skipped, TickCost& cost) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begun = Clock::now();
  model_->move_to(t);
  model_->prepare();
  const Clock::time_point rendered = Clock::now();
  const model::Logits logits = model_->classify();
  TickVerdict verdict{.t = t,
                      .events = model_->events(),
                      .probabilities = model::probabilities_of(logits, temperature_),
                      .predicted = model::verdict_of(logits)};
  decision_.skip(skipped);
  verdict.verdict = decision_.next(verdict.predicted, verdict.probabilities);
  verdict.slip_is_confirmed = decision_.confirms_slip();
  cost = {.rendering = rendered - begun, .network = Clock::now() - rendered};
  return verdict;
}

void TickDetector::rehearse() {
  model_->prepare();
  model_->classify();
}

void TickDetector::restart() {
  model_->restart();
  decision_.restart();
}

}  // namespace tactile::detect
