#include "tactile/events/event_checks.hpp"

#include <cstddef>
#include <cstdint>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace tactile {
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
/// Two events in one register. As eight numbers of 16 bits an event is four of its time, x, y, the polarity below a byte of
/// padding, and padding. That byte counts as polarity here: what this finds outside is worth another look.
__attribute__((target("avx2"))) EventsCheck check_in_pairs(std::span<const Event> events, SensorSize size) {
  const auto most_x = static_cast<std::int16_t>(size.width - 1), most_y = static_cast<std::int16_t>(size.height - 1);
  const __m256i most = _mm256_setr_epi16(-1, -1, -1, -1, most_x, most_y, 1, -1, -1, -1, -1, -1, most_x, most_y, 1, -1);
  const __m256i times = _mm256_setr_epi64x(-1, 0, -1, 0);
  __m256i over[2] = {_mm256_setzero_si256(), _mm256_setzero_si256()}, falls[2] = {over[0], over[0]};
  const Event* event = events.data();
  std::size_t i = 1;
  for (; i + 4 <= events.size(); i += 4) {
    for (std::size_t k = 0; k < 2; ++k) {
      const __m256i pair = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(event + i + 2 * k));
      const __m256i before = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(event + i + 2 * k - 1));
      over[k] = _mm256_or_si256(over[k], _mm256_subs_epu16(pair, most));
      falls[k] = _mm256_or_si256(falls[k], _mm256_cmpgt_epi64(before, pair));
    }
  }
  const EventsCheck first = check_one_by_one(events.first(1), size);
  const EventsCheck rest = check_one_by_one(events.subspan(i - 1), size);
  const __m256i any_over = _mm256_or_si256(over[0], over[1]), any_falls = _mm256_or_si256(falls[0], falls[1]);
  return {.inside = first.inside && rest.inside && _mm256_testz_si256(any_over, any_over) != 0,
          .ascending = rest.ascending && _mm256_testz_si256(any_falls, times) != 0};
}
#endif

}  // namespace

EventsCheck check_events(std::span<const Event> events, SensorSize size) {
#if defined(__x86_64__)
  static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
  if (has_avx2 && events.size() > 4) {
    const EventsCheck check = check_in_pairs(events, size);
    return check.inside ? check : check_one_by_one(events, size);
  }
#endif
  return check_one_by_one(events, size);
}

}  // namespace tactile
