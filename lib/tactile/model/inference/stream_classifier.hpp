#pragma once

#include <cstdint>
#include <memory>

#include "tactile/model/inference/stream_network.hpp"
#include "tactile/model/inference/tick_classifier.hpp"

namespace tactile::model {

/// A model of kind `stream` on the events of a stream.
class StreamClassifier final : public TickClassifier {
 public:
  /// @throws Error  as TickClassifier
  StreamClassifier(events::SensorSize sensor, microseconds tick, const events::MaskPixels& mask,
                   std::shared_ptr<const StreamNetwork> network);

  std::uint64_t events() const override { return events_; }  ///< of the last tick

 private:
  Logits advance(std::span<const events::Event> of_tick, CameraTime tick) override;
  bool is_at_rest() const override { return state_.at_rest; }
  void forget() override;

  std::shared_ptr<const StreamNetwork> network_;
  StreamCounts counts_;
  StreamState state_;
  std::uint64_t events_ = 0;
};

}  // namespace tactile::model
