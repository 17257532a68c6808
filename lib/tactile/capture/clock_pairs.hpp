#pragma once

#include <cstddef>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile {

struct ClockPair {
  CameraTime camera;
  HostTime host;

  friend bool operator==(const ClockPair&, const ClockPair&) = default;
};

/// When elements arrived on the host, so that its clock can later be related to the camera's. An element may come late, and never
/// early: of each second (of the host) that pair is kept whose difference host - camera is the smallest. Beyond `limit` pairs
/// neighbours are merged by the same rule and the second becomes two, then four, and so on.
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

}  // namespace tactile
