#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::capture {

struct ClockPair {
  CameraTime camera;
  HostTime host;

  friend bool operator==(const ClockPair&, const ClockPair&) = default;
};

/// How the camera's clock goes against the host's so far.
struct ClockOffset {
  microseconds offset{0};  ///< host - camera: the smallest of the last second or two
  microseconds change{0};  ///< since that of the first second or two
  microseconds span{0};    ///< host time between the two
};

/// Arrival times of elements, from which the relation of the camera's clock to the host's can be computed later. An element can
/// arrive late, but never early. Therefore, of each second in host time, the pair with the smallest difference host - camera is
/// kept. Beyond `limit` pairs, neighbours are merged by the same rule: the second becomes two seconds, then four, and so on.
class ClockPairs {
 public:
  explicit ClockPairs(std::size_t limit = 4096) : limit_(limit) {}  ///< >= 2

  void add(CameraTime camera, HostTime host);
  const std::vector<ClockPair>& pairs() const { return pairs_; }  ///< in the order of host time
  std::optional<ClockOffset> offset() const;                      ///< nothing without a pair

 private:
  void take(const ClockPair& pair);

  std::size_t limit_;
  microseconds period_{1'000'000};
  std::vector<ClockPair> pairs_;
};

/// The lateness of a packet is its arrival after that of the earliest packet near it, as `ClockPairs` keeps them. Of the last 0.1
/// to 0.2 s this is the largest.
class RecentLateness {
 public:
  void add(HostTime arrived, microseconds lateness);
  microseconds most(HostTime now) const;  ///< 0 after a silence of 0.2 s

 private:
  HostTime begin_{};
  microseconds before_{0}, now_{0};  ///< of the last 0.1 s, and since
};

}  // namespace tactile::capture
