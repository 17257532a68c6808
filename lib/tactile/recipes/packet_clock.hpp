#pragma once

#include <algorithm>
#include <cmath>

#include "tactile/recipes/recording_clock.hpp"

namespace tactile::recipes {

/// Divides a recording into packets of equal duration from its first event. A packet without events does not exist.
class PacketClock {
 public:
  /// @param packet_ms  >= 0.001
  explicit PacketClock(double packet_ms) : packet_(std::max<std::int64_t>(1, std::llround(1000 * packet_ms))) {}

  /// Moves to the next event. @return  whether it is the first of its packet
  bool advance(CameraTime t) {
    const std::int64_t packet = clock_.advance(t) / packet_;
    const bool is_first = packet != number_;
    number_ = packet;
    return is_first;
  }

  /// From the last event to the end of its packet, > 0.
  microseconds until_end() const { return (number_ + 1) * packet_ - clock_.elapsed(); }

 private:
  microseconds packet_;
  RecordingClock clock_;
  std::int64_t number_ = -1;
};

}  // namespace tactile::recipes
