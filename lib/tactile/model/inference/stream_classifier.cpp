#include "tactile/model/inference/stream_classifier.hpp"

#include <utility>

namespace tactile::model {

StreamClassifier::StreamClassifier(events::SensorSize sensor, microseconds tick, const events::MaskPixels& mask,
                                   std::shared_ptr<const StreamNetwork> network)
    : TickClassifier(sensor, tick, mask), network_(std::move(network)), counts_(sensor, network_->grid()) {}

Logits StreamClassifier::advance(std::span<const events::Event> of_tick, CameraTime) {
  counts_.clear();
  for (const events::Event& event : of_tick) counts_.count(event);
  network_->advance(counts_, state_);
  events_ = of_tick.size();
  return state_.logits;
}

void StreamClassifier::forget() {
  counts_.clear();
  state_ = {};
  events_ = 0;
}

}  // namespace tactile::model
