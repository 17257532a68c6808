#pragma once

#include <cstdint>
#include <span>

#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile::model {

/// A trained model that follows a stream of events, whatever it reads of them. At each tick: `move_to`, then `prepare`, then
/// `classify`; the last two may be left out or repeated. The logits depend only on the events of the history, never on which
/// ticks were asked for before. Memory is allocated only for a history with more events than any before. Of one thread.
class EventClassifier {
 public:
  virtual ~EventClassifier() = default;

  /// Appends events, ascending in time and not before earlier ones. They are counted by `move_to`.
  /// @throws Error  if they go back in time or lie outside the sensor; then none of them is added
  virtual void add(std::span<const events::Event> events) = 0;

  /// Moves the history to [tick - t_h, tick); later events wait. @throws Error  if `tick` is before the last one
  virtual void move_to(CameraTime tick) = 0;

  virtual std::uint64_t events() const = 0;  ///< in the history
  virtual void prepare() = 0;                ///< makes the input from the history, such as a heatmap
  virtual Logits classify() = 0;             ///< the logits of the input that was prepared last
  virtual void restart() = 0;                ///< forgets all events: the next ones may have any time
};

}  // namespace tactile::model
