#pragma once

#include <cstdint>
#include <optional>

#include "tactile/core/time.hpp"

namespace tactile::video {

/// Gives a source's frames times that always ascend. The first frame is at 0.
///
/// The time from frame to frame is the source's own. Where that is impossible:
///   - for a live source (its time stands still, steps back, or runs 5 s ahead of the host's): the time between their arrivals;
///   - for a recorded one: a frame whose time stands still or steps back is a duplicate and has no time. If no time has ascended
///   by
///     the third frame, the file has no times, and from then on frames are one `frame` apart. The same holds where the time steps
///     back by more than a second (it restarts) or ahead by more than an hour.
class FrameClock {
 public:
  /// @param frame  of a recorded source: the time from frame to frame if it has no times, > 0
  FrameClock(bool live, microseconds frame) : live_(live), frame_(frame) {}

  /// @param source_ms  the source's time of this frame; any value
  /// @param arrived    when it arrived
  /// @return           its time, or nothing for a duplicate
  std::optional<microseconds> time_of(double source_ms, HostTime arrived);

  /// Whether the last step was the source's own.
  bool is_own() const { return own_; }

 private:
  bool live_ = false;
  microseconds frame_;
  bool begun_ = false;
  bool ascended_ = false;  ///< the source has given a time that ascends
  int standing_ = 0;       ///< frames whose time did not ascend, before any did
  double source_ms_ = 0;   ///< of the last frame
  HostTime arrived_{};
  bool own_ = false;
  microseconds t_{0};
};

}  // namespace tactile::video
