#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/pixel_mask.hpp"

namespace tactile::events {

/// Events that wait until a tick takes them, in order of time. Memory is allocated only if more wait than ever before.
class WaitingEvents {
 public:
  /// @param mask  pixels whose events do not wait
  /// @throws Error  if the sensor has no area or too long a side, or a masked pixel lies outside it
  explicit WaitingEvents(SensorSize sensor, const MaskPixels& mask = {});

  /// Appends events, ascending in time and not before earlier ones.
  /// @throws Error  if they go back in time or lie outside the sensor; then none of them is added
  void add(std::span<const Event> events);

  /// The time of the first one that waits.
  std::optional<CameraTime> next() const;

  /// Those before `t`, which then wait no longer. Valid until the next call of a member.
  std::span<const Event> take_before(CameraTime t);

 private:
  SensorSize sensor_;
  PixelMask mask_;
  std::vector<Event> waiting_, unmasked_;
  std::size_t next_ = 0;                 ///< of the waiting events
  CameraTime last_ = CameraTime::min();  ///< of the added events
};

}  // namespace tactile::events
