#pragma once

#include <cstdint>
#include <optional>

#include "tactile/core/time.hpp"

namespace tactile::detect {

/// How long the packets of a quiet stream can wait unread: until the earliest time at which a packet can close the next tick. The
/// time is estimated from the last one or two quarters of a second.
class QuietStream {
 public:
  /// @param knows_arrival  whether the packet's arrival is known; otherwise a packet read late would seem to arrive late
  void packet(std::uint64_t events, bool knows_arrival);
  /// A tick was closed by an event at `closed`, `waited` after its end on the host.
  void tick(microseconds waited, HostTime closed);
  void tick_reported() { events_since_tick_ = 0; }
  void restart() { *this = {}; }

  /// The least time between the end of a tick and the packet that closes it; nothing if the stream is busy or not yet known.
  std::optional<microseconds> least_waiting(HostTime now) const;

 private:
  void forget();

  HostTime period_begin_{};
  std::optional<microseconds> last_period_, this_period_;
  std::uint64_t events_since_tick_ = 0;
};

}  // namespace tactile::detect
