#pragma once

#include <cstdint>
#include <optional>

#include "tactile/core/time.hpp"
#include "tactile/events/waiting_events.hpp"
#include "tactile/model/inference/event_classifier.hpp"

namespace tactile::model {

/// A model that remembers. It advances at every whole multiple of its tick from the first event on, whichever ticks are asked
/// for, so the logits of a tick depend on all events before it.
class TickClassifier : public EventClassifier {
 public:
  /// @param tick  of the training, since the model counts by it
  /// @throws Error  if the tick is not above 0, or the sensor has no area
  TickClassifier(events::SensorSize sensor, microseconds tick, const events::MaskPixels& mask);

  void add(std::span<const events::Event> events) final { waiting_.add(events); }
  void move_to(CameraTime tick) final;
  void prepare() final {}
  Logits classify() final { return logits_; }
  void restart() final;

 protected:
  /// The logits of the next tick. @param of_tick  the events since the tick before, without masked pixels
  virtual Logits advance(std::span<const events::Event> of_tick, CameraTime tick) = 0;
  virtual bool is_at_rest() const { return false; }  ///< whether a tick without events changes nothing any more
  virtual void forget() = 0;                         ///< as before the first event

 private:
  events::SensorSize sensor_;
  microseconds tick_;
  events::MaskPixels mask_;
  events::WaitingEvents waiting_;
  Logits logits_{};
  std::optional<CameraTime> reached_;  ///< the last tick that was computed
  CameraTime moved_to_ = CameraTime::min();
};

}  // namespace tactile::model
