#pragma once

#include <cstdint>
#include <string>

#include "tactile/core/time.hpp"

namespace tactile {

/// The smallest tick >= t, and the largest <= t. Ticks are whole multiples of `tick` of camera time, negative ones included.
/// Where no tick lies before the end of the clock, the result is the end of the clock.
CameraTime first_tick_from(CameraTime t, microseconds tick);
CameraTime last_tick_until(CameraTime t, microseconds tick);

/// Consecutive ticks of a run.
struct TickRange {
  CameraTime first{};
  std::int64_t count = 0;
  microseconds tick{2'000};

  CameraTime at(std::int64_t index) const;  ///< of an index in [0, count]; limited to the end of the clock
};

/// The full ticks of a run: those with t - history >= first_event and t <= last_event.
/// @throws Error  if `tick` is not above 0 or `history` is below 0
TickRange full_ticks(CameraTime first_event, CameraTime last_event, microseconds history, microseconds tick);

/// The most ticks of one recording: 55 hours at 2 ms. Every tick takes memory, and a recording that seems longer most likely has
/// a damaged time.
inline constexpr std::int64_t most_ticks = 100'000'000;

/// Why there are too many: "15768000000 ticks of 2000 us from the first event to the last; expected ..."; empty if there are not.
std::string why_too_many(const TickRange& ticks);

}  // namespace tactile
