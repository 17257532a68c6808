#pragma once

#include <cstddef>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::capture {

struct ClockPair {
  CameraTime camera;
  HostTime host;

  friend bool operator==(const ClockPair&, const ClockPair&) = default;
};

/// Arrival times of elements, from which the relation of the camera's clock to the host's can be computed later. An element can
/// arrive late, but never early. Therefore, of each second in host time, the pair with the smallest difference host - camera is
/// kept. Beyond `limit` pairs, neighbours are merged by the same rule: the second becomes two seconds, then four, and so on.
class ClockPairs {
 public:
  explicit ClockPairs(std::size_t limit = 4096) : limit_(limit) {}  ///< >= 2

  void add(CameraTime camera, HostTime host);
  const std::vector<ClockPair>& pairs() const { return pairs_; }  ///< in the order of host time

 private:
  void take(const ClockPair& pair);

  std::size_t limit_;
  microseconds period_{1'000'000};
  std::vector<ClockPair> pairs_;
};

}  // namespace tactile::capture
