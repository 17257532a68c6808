#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile {

/// What a device's clock and the host's showed when something of the device arrived.
template <class Clock>
struct ClockPair {
  std::chrono::time_point<Clock, microseconds> device;
  HostTime host;

  friend bool operator==(const ClockPair&, const ClockPair&) = default;
};

/// How a device's clock goes against the host's so far, from its first period to its last one. A period is a second, or more
/// after `ClockPairs`' limit.
struct ClockOffset {
  microseconds offset{0};  ///< host - device: the smallest of the last period or two
  microseconds change{0};  ///< since that of the first period or two
  microseconds span{0};    ///< host time between the two
};

/// Arrival times of elements, from which the relation of a device's clock to the host's can be computed later. An element can
/// arrive late, but never early. Therefore, of each second in host time, the pair with the smallest difference host - device is
/// kept. Beyond `limit` pairs, neighbours are merged by the same rule: the period becomes two seconds, then four, and so on.
///
/// @tparam Clock  CameraClock, RobotClock or VideoClock
template <class Clock>
class ClockPairs {
 public:
  explicit ClockPairs(std::size_t limit = 4096) : limit_(limit) {}  ///< >= 2

  void add(const ClockPair<Clock>& pair);
  const std::vector<ClockPair<Clock>>& pairs() const { return pairs_; }  ///< in the order of host time
  std::optional<ClockOffset> offset() const;                             ///< nothing without a pair

 private:
  void take(const ClockPair<Clock>& pair);

  std::size_t limit_;
  microseconds period_{1'000'000};
  std::vector<ClockPair<Clock>> pairs_;
};

extern template class ClockPairs<CameraClock>;
extern template class ClockPairs<RobotClock>;
extern template class ClockPairs<VideoClock>;

}  // namespace tactile
