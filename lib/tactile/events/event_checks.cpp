#include "tactile/events/event_checks.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace tactile::events {
namespace {

EventsCheck check_one_by_one(std::span<const Event> events, SensorSize size) {
  const auto width = static_cast<std::uint32_t>(size.width), height = static_cast<std::uint32_t>(size.height);
  unsigned outside = 0, falls = 0;
  std::int64_t previous = events.empty() ? 0 : us_of(events.front().t);
  for (const Event& e : events) {
    outside |= static_cast<unsigned>(static_cast<std::uint16_t>(e.x) >= width) |
               static_cast<unsigned>(static_cast<std::uint16_t>(e.y) >= height) | static_cast<unsigned>(e.on > 1);
    falls |= static_cast<unsigned>(us_of(e.t) < previous);
    previous = us_of(e.t);
  }
  return {.inside = outside == 0, .ascending = falls == 0};
}

#if defined(__x86_64__)
/// Checks four events at a time, two per register. An event is eight numbers of 16 bits: four of its time, x, y, the polarity
/// with a byte of padding, and padding. That byte counts as polarity here, so events found outside must be checked again.
__attribute__((target("avx2"))) EventsCheck check_in_pairs(std::span<const Event> events, SensorSize size) {
  const auto most_x = static_cast<std::int16_t>(size.width - 1), most_y = static_cast<std::int16_t>(size.height - 1);
  const __m256i most = _mm256_setr_epi16(-1, -1, -1, -1, most_x, most_y, 1, -1, -1, -1, -1, -1, most_x, most_y, 1, -1);
  __m256i largest[2] = {_mm256_setzero_si256(), _mm256_setzero_si256()}, falls = largest[0];
  const Event* event = events.data();
  const std::size_t begin = reinterpret_cast<std::uintptr_t>(event) % sizeof most == sizeof(Event) ? 1 : 0;  // for aligned loads
  __m256i before = _mm256_set1_epi64x(us_of(event[begin].t));
  std::size_t i = begin;
  for (; i + 4 <= events.size(); i += 4) {
    const __m256i first = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(event + i));
    const __m256i second = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(event + i + 2));
    largest[0] = _mm256_max_epu16(largest[0], first);
    largest[1] = _mm256_max_epu16(largest[1], second);
    const __m256i times = _mm256_unpacklo_epi64(first, second);                       // of the events 0, 2, 1, 3
    const __m256i turned = _mm256_permute4x64_epi64(times, _MM_SHUFFLE(1, 0, 2, 3));  // of 3, 1, 0, 2
    falls = _mm256_or_si256(falls, _mm256_cmpgt_epi64(_mm256_blend_epi32(turned, before, 3), times));
    before = turned;
  }
  const __m256i over = _mm256_subs_epu16(_mm256_max_epu16(largest[0], largest[1]), most);
  const EventsCheck start = check_one_by_one(events.first(begin + 1), size);
  const EventsCheck rest = check_one_by_one(events.subspan(i - 1), size);
  return {.inside = start.inside && rest.inside && _mm256_testz_si256(over, over) != 0,
          .ascending = start.ascending && rest.ascending && _mm256_testz_si256(falls, falls) != 0};
}
#endif

}  // namespace

SensorSize bounds_of(const std::optional<SensorSize>& declared) {
  constexpr int most = std::numeric_limits<std::int16_t>::max() + 1;
  const SensorSize size = declared.value_or(SensorSize{.width = most, .height = most});
  return {.width = std::min(size.width, most), .height = std::min(size.height, most)};
}

EventsCheck check_events(std::span<const Event> events, SensorSize size) {
#if defined(__x86_64__)
  static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
  if (has_avx2 && events.size() > 8) {
    const EventsCheck check = check_in_pairs(events, size);
    return check.inside ? check : check_one_by_one(events, size);
  }
#endif
  return check_one_by_one(events, size);
}

std::span<Event> without_outside(std::span<Event> events, SensorSize size) {
  const auto kept_end = std::remove_if(events.begin(), events.end(), [size](const Event& e) { return is_outside(e, size); });
  return events.first(static_cast<std::size_t>(kept_end - events.begin()));
}

}  // namespace tactile::events
