#pragma once

#include "tactile/core/time.hpp"

namespace tactile::capture {

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
