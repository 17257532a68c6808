#pragma once

#include <cstdint>
#include <optional>

#include "tactile/core/time.hpp"

namespace tactile {

/// Puts a source's frames on one line of time that always ascends, whatever the source tells of them. The first frame is at 0.
///
/// A frame lies as far behind the one before it as the source tells. Where that cannot be:
///   - a live source (its time stands still, steps back, or runs 5 s ahead of the host's): as far as they came after each other;
///   - a recorded one: a frame whose time stands still or steps back is a duplicate and has no place. But where no time has
///     ascended by the third frame the file tells none, and from then on frames lie one `frame` apart, as they do where the time
///     steps back by more than a second (it has begun anew) or ahead by more than an hour.
class FrameClock {
 public:
  /// @param frame  of a recorded source: the time from frame to frame where it tells none, > 0
  FrameClock(bool live, microseconds frame) : live_(live), frame_(frame) {}

  /// @param told_ms  what the source tells of this frame's time; any value
  /// @param came     when it came
  /// @return         its time on the line, or nothing for a duplicate
  std::optional<microseconds> time_of(double told_ms, HostTime came);

 private:
  bool live_ = false;
  microseconds frame_;
  bool begun_ = false;
  bool ascended_ = false;  ///< the source has told a time that ascends
  int standing_ = 0;       ///< frames whose time did not ascend, before any did
  double told_ms_ = 0;     ///< of the last frame
  HostTime came_{};
  microseconds t_{0};
};

}  // namespace tactile
