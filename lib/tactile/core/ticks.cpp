#include "tactile/core/ticks.hpp"

#include <algorithm>
#include <limits>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

/// The distance of `us` from the largest multiple of `tick` that does not exceed it.
std::int64_t remainder_of(std::int64_t us, microseconds tick) {
  const std::int64_t remainder = us % tick.count();
  return remainder < 0 ? remainder + tick.count() : remainder;
}

}  // namespace

CameraTime first_tick_from(CameraTime t, microseconds tick) {
  const std::int64_t above = remainder_of(us_of(t), tick);
  return above == 0 ? t : after(t, microseconds{tick.count() - above});
}

CameraTime last_tick_until(CameraTime t, microseconds tick) { return before(t, microseconds{remainder_of(us_of(t), tick)}); }

CameraTime TickRange::at(std::int64_t index) const {
  // The distance between the ends of the clock exceeds int64.
  const std::uint64_t on = static_cast<std::uint64_t>(tick.count()) * static_cast<std::uint64_t>(index);
  const std::uint64_t room = static_cast<std::uint64_t>(us_of(CameraTime::max())) - static_cast<std::uint64_t>(us_of(first));
  if (on > room) return CameraTime::max();
  return camera_time(static_cast<std::int64_t>(static_cast<std::uint64_t>(us_of(first)) + on));
}

TickRange full_ticks(CameraTime first_event, CameraTime last_event, microseconds history, microseconds tick) {
  if (tick <= microseconds{0} || history < microseconds{0})
    throw Error("ticks of " + std::to_string(tick.count()) + " us; expected more than 0");
  TickRange range{.first = {}, .count = 0, .tick = tick};
  const CameraTime begin = after(first_event, history);
  const CameraTime first = first_tick_from(begin, tick), last = last_tick_until(last_event, tick);
  // A time that is limited to an end of the clock is not a tick, so no full tick remains there.
  const bool beyond =
      between(first_event, begin) != history || remainder_of(us_of(first), tick) != 0 || remainder_of(us_of(last), tick) != 0;
  if (beyond || first > last) return range;
  range.first = first;
  const std::uint64_t span = static_cast<std::uint64_t>(us_of(last)) - static_cast<std::uint64_t>(us_of(first));
  const std::uint64_t steps = span / static_cast<std::uint64_t>(tick.count());
  range.count = static_cast<std::int64_t>(std::min<std::uint64_t>(steps, std::numeric_limits<std::int64_t>::max() - 1) + 1);
  return range;
}

std::string why_too_many(const TickRange& ticks) {
  if (ticks.count <= most_ticks) return "";
  return std::to_string(ticks.count) + " ticks of " + std::to_string(ticks.tick.count()) +
         " us from the first event to the last; expected at most " + std::to_string(most_ticks) +
         ". Cut the recording with 'tactile convert --from-us --to-us', or check for damaged times";
}

}  // namespace tactile
