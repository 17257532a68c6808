#include "tactile/events/event_checks.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

// Highway compiles what follows once for each kind of processor and takes the best of them at run time.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tactile/events/event_checks.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tactile::events::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

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

#if HWY_TARGET == HWY_SCALAR
EventsCheck check_in_vectors(std::span<const Event> events, SensorSize size) { return check_one_by_one(events, size); }
#else
/// Checks two vectors of events at a time. An event is eight numbers of 16 bits: four of its time, x, y, the polarity with a byte
/// of padding, and padding. That byte counts as polarity here, so events found outside must be checked again.
EventsCheck check_in_vectors(std::span<const Event> events, SensorSize size) {
  const hn::ScalableTag<std::uint16_t> words;
  const hn::ScalableTag<std::int64_t> longs;
  const std::size_t events_of_vector = hn::Lanes(words) / 8, lanes = hn::Lanes(longs);
  if (events.size() <= 4 * events_of_vector) return check_one_by_one(events, size);
  constexpr std::uint16_t any = 0xFFFF;
  const auto most_x = static_cast<std::uint16_t>(size.width - 1), most_y = static_cast<std::uint16_t>(size.height - 1);
  HWY_ALIGN const std::uint16_t most[8] = {any, any, any, any, most_x, most_y, 1, any};
  // Two vectors hold the times in the order 0, k, 1, k + 1, ...; the time before each of them is found at these lanes. The first
  // is that of the last event, which the next pair of vectors needs.
  HWY_ALIGN std::int64_t lane_before[hn::MaxLanes(longs)];
  for (std::size_t lane = 2; lane < lanes; ++lane) lane_before[lane] = static_cast<std::int64_t>(lane - 2);
  lane_before[0] = static_cast<std::int64_t>(lanes - 1), lane_before[1] = static_cast<std::int64_t>(lanes - 2);
  const auto place_before = hn::SetTableIndices(longs, lane_before);
  const auto is_first = hn::FirstN(longs, 1);
  const Event* const all = events.data();
  const std::size_t vector_bytes = events_of_vector * sizeof(Event);
  const std::size_t begin = (vector_bytes - reinterpret_cast<std::uintptr_t>(all) % vector_bytes) % vector_bytes / sizeof(Event);
  auto largest = hn::Zero(words), largest_of_second = largest;
  auto before = hn::Set(longs, us_of(all[begin].t)), falls = hn::Zero(longs);
  std::size_t i = begin;
  for (; i + 2 * events_of_vector <= events.size(); i += 2 * events_of_vector) {
    const auto first = hn::LoadU(words, reinterpret_cast<const std::uint16_t*>(all + i));
    const auto second = hn::LoadU(words, reinterpret_cast<const std::uint16_t*>(all + i + events_of_vector));
    largest = hn::Max(largest, first);
    largest_of_second = hn::Max(largest_of_second, second);
    const auto times = hn::InterleaveLower(longs, hn::BitCast(longs, first), hn::BitCast(longs, second));
    const auto turned = hn::TableLookupLanes(times, place_before);
    falls = hn::Or(falls, hn::VecFromMask(longs, hn::Lt(times, hn::IfThenElse(is_first, before, turned))));
    before = turned;
  }
  const auto over = hn::SaturatedSub(hn::Max(largest, largest_of_second), hn::LoadDup128(words, most));
  const EventsCheck start = check_one_by_one(events.first(begin + 1), size), rest = check_one_by_one(events.subspan(i - 1), size);
  return {.inside = start.inside && rest.inside && hn::AllTrue(words, hn::Eq(over, hn::Zero(words))),
          .ascending = start.ascending && rest.ascending && hn::AllTrue(longs, hn::Eq(falls, hn::Zero(longs)))};
}
#endif

EventsCheck check(std::span<const Event> events, SensorSize size) {
  const EventsCheck found = check_in_vectors(events, size);
  return found.inside ? found : check_one_by_one(events, size);
}

}  // namespace
}  // namespace tactile::events::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tactile::events {
namespace {

HWY_EXPORT(check);

}  // namespace

SensorSize bounds_of(const std::optional<SensorSize>& declared) {
  constexpr int most = std::numeric_limits<std::int16_t>::max() + 1;
  const SensorSize size = declared.value_or(SensorSize{.width = most, .height = most});
  return {.width = std::min(size.width, most), .height = std::min(size.height, most)};
}

EventsCheck check_events(std::span<const Event> events, SensorSize size) { return HWY_DYNAMIC_DISPATCH(check)(events, size); }

std::span<Event> without_outside(std::span<Event> events, SensorSize size) {
  const auto kept_end = std::remove_if(events.begin(), events.end(), [size](const Event& e) { return is_outside(e, size); });
  return events.first(static_cast<std::size_t>(kept_end - events.begin()));
}

}  // namespace tactile::events
#endif
