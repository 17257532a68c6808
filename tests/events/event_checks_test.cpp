#include "tactile/events/event_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "events/aedat4_bytes.hpp"

namespace tactile::events {
namespace {

using test::event;

constexpr SensorSize size{640, 480};

/// Event by event, as the header defines it.
EventsCheck plainly(std::span<const Event> events) {
  EventsCheck check;
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (is_outside(events[i], size)) check.inside = false;
    if (i > 0 && events[i].t < events[i - 1].t) check.ascending = false;
  }
  return check;
}

TEST(EventChecks, KnowWhatIsOutside) {
  EXPECT_FALSE(is_outside(event(0, 0, 0, 0), size));
  EXPECT_FALSE(is_outside(event(0, 639, 479, 1), size));
  EXPECT_TRUE(is_outside(event(0, 640, 0, 0), size));
  EXPECT_TRUE(is_outside(event(0, 0, 480, 0), size));
  EXPECT_TRUE(is_outside(event(0, -1, 0, 0), size));
  EXPECT_TRUE(is_outside(event(0, 0, -1, 0), size));
  EXPECT_TRUE(is_outside(event(0, 0, 0, 2), size));
}

TEST(EventChecks, TakeEveryPlaceThatIsNotNegativeWhereNoSizeIsDeclared) {
  EXPECT_EQ(bounds_of(std::nullopt), (SensorSize{32'768, 32'768}));
  EXPECT_EQ(bounds_of(SensorSize{640, 100'000}), (SensorSize{640, 32'768}));
  EXPECT_EQ(bounds_of(size), size);
}

TEST(EventChecks, FindOneFlawWhereverItIs) {
  constexpr auto earliest = std::numeric_limits<std::int64_t>::min(), latest = std::numeric_limits<std::int64_t>::max();
  const std::vector<std::function<void(Event&)>> flaws{
      [](Event& e) { e.x = 640; },
      [](Event& e) { e.x = -1; },
      [](Event& e) { e.y = 480; },
      [](Event& e) { e.y = -32'768; },
      [](Event& e) { e.on = 2; },
      [](Event& e) { e.on = 255; },
      [](Event& e) { e.t = camera_time(0); },
      [](Event& e) { e.t = camera_time(2'000'000); },
      [](Event& e) { e.t = camera_time(earliest); },
      [](Event& e) { e.t = camera_time(latest); },
      [](Event&) {},
  };
  for (std::size_t from = 0; from < 4; ++from) {  // events at addresses of every kind
    for (std::size_t count = 0; count < 24; ++count) {
      for (std::size_t at = 0; at < std::max<std::size_t>(count, 1); ++at) {
        for (std::size_t flaw = 0; flaw < flaws.size(); ++flaw) {
          std::vector<Event> events(from + count);
          for (std::size_t i = 0; i < events.size(); ++i) {
            const int n = static_cast<int>(i);
            events[i] = event(1'000'000 + n / 2, n * 101 % 640, 479 - n, n % 2);
          }
          if (count > 0) flaws[flaw](events[from + at]);
          // The events before and after must have no effect.
          if (from > 0) events[from - 1] = event(latest, -1, -1, 7);
          events.push_back(event(earliest, -1, -1, 7));
          const auto looked_at = std::span<const Event>(events).subspan(from, count);
          const EventsCheck check = check_events(looked_at, size), expected = plainly(looked_at);
          ASSERT_EQ(check.inside, expected.inside) << "flaw " << flaw << " at " << at << " of " << count << " from " << from;
          ASSERT_EQ(check.ascending, expected.ascending)
              << "flaw " << flaw << " at " << at << " of " << count << " from " << from;
        }
      }
    }
  }
}

TEST(EventChecks, GoUpToTheLargestSensor) {
  const std::vector<Event> far(9, event(0, 32'767, 32'767, 0));
  EXPECT_TRUE(check_events(far, {32'768, 32'768}).inside);
  EXPECT_FALSE(check_events(far, {32'767, 32'768}).inside);
  EXPECT_FALSE(check_events(far, {32'768, 32'767}).inside);
}

TEST(EventChecks, LookPastWhatPaddingHolds) {
  std::vector<Event> events(50);
  for (std::size_t i = 0; i < events.size(); ++i) events[i] = event(static_cast<std::int64_t>(i), 1, 2, 1);
  auto* bytes = reinterpret_cast<unsigned char*>(events.data());
  for (std::size_t i = 0; i < events.size(); ++i)
    std::fill_n(bytes + i * sizeof(Event) + 13, 3, static_cast<unsigned char>(0xFF));
  EXPECT_TRUE(check_events(events, size).inside);
  EXPECT_TRUE(check_events(events, size).ascending);
}

TEST(EventChecks, DropWhatIsOutsideAndKeepTheOrder) {
  std::vector<Event> events{event(1, 640, 0, 0), event(2, 5, 6, 1), event(3, 0, -1, 0), event(4, 7, 8, 0), event(5, 0, 0, 3)};
  const std::span<Event> kept = without_outside(events, size);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0], event(2, 5, 6, 1));
  EXPECT_EQ(kept[1], event(4, 7, 8, 0));
}

}  // namespace
}  // namespace tactile::events
