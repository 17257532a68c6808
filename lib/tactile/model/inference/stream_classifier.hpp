#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "tactile/events/waiting_events.hpp"
#include "tactile/model/inference/event_classifier.hpp"
#include "tactile/model/inference/stream_network.hpp"

namespace tactile::model {

/// A model of kind `stream` on the events of a stream. It advances at every whole multiple of its tick from the first event on,
/// whichever ticks are asked for, so the logits of a tick depend on all events before it.
class StreamClassifier final : public EventClassifier {
 public:
  /// @param tick  of the training, since the network counts by it
  /// @throws Error  if a tick is not above 0, or the sensor has no area
  StreamClassifier(events::SensorSize sensor, microseconds tick, const events::MaskPixels& mask,
                   std::shared_ptr<const StreamNetwork> network);

  void add(std::span<const events::Event> events) override { waiting_.add(events); }
  void move_to(CameraTime tick) override;
  std::uint64_t events() const override { return events_; }  ///< of the last tick
  void prepare() override {}
  Logits classify() override { return state_.logits; }
  void restart() override;

 private:
  void advance_to(CameraTime tick);

  events::SensorSize sensor_;
  microseconds tick_;
  events::MaskPixels mask_;
  std::shared_ptr<const StreamNetwork> network_;
  events::WaitingEvents waiting_;
  StreamCounts counts_;
  StreamState state_;
  std::uint64_t events_ = 0;
  std::optional<CameraTime> reached_;  ///< the last tick that was computed
  CameraTime moved_to_ = CameraTime::min();
};

}  // namespace tactile::model
