#pragma once

#include "tactile/alignment/activity.hpp"
#include "tactile/alignment/event_rate.hpp"

namespace tactile::splitting {

/// Of a recording of 4 s in bins of 1 ms, quiet but for the bursts that a test adds.
inline const alignment::EventRate quiet_rate{.begin = camera_time(1'000'000),
                                             .bin = 1ms,
                                             .counts = std::vector<std::uint32_t>(4'000),
                                             .hot_pixels = 0,
                                             .last = camera_time(5'000'000),
                                             .hot = {}};

/// In the time of that recording.
inline CameraTime at_ms(std::int64_t ms) { return camera_time(1'000'000 + 1'000 * ms); }

inline alignment::Burst burst(std::size_t begin_ms, std::size_t end_ms, double events = 50'000) {
  alignment::Burst made;
  made.begin = begin_ms;
  made.end = end_ms;
  made.events = events;
  return made;
}

}  // namespace tactile::splitting
