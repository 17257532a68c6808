#include "tactile/review/touched_places.hpp"

#include <gtest/gtest.h>

#include "tactile/core/random.hpp"

namespace tactile::review {
namespace {

events::Event event_at(std::int64_t us, int x, int y) {
  events::Event event;
  event.t = camera_time(us);
  event.x = static_cast<std::int16_t>(x);
  event.y = static_cast<std::int16_t>(y);
  return event;
}

/// A press from 1 s to 2 s, whose ends are known within 50 ms, in 4 s.
labels::Labels with_press() {
  labels::Labels labels;
  labels::LabelledInterval press;
  press.id = "press-1";
  press.touch = Touch::press;
  press.start = {.at = camera_time(1'000'000), .low = camera_time(950'000), .high = camera_time(1'050'000)};
  press.end = {.at = camera_time(2'000'000), .low = camera_time(1'950'000), .high = camera_time(2'050'000)};
  labels.intervals.push_back(press);
  return labels;
}

TouchedPlaces places_of(const labels::Labels& labels, const std::vector<events::Event>& events) {
  TouchedPlaces places({64, 48}, labels, camera_time(0), camera_time(4'000'000));
  places.add(events);
  places.choose();
  return places;
}

/// Noise everywhere, and `marker` events at (20, 20) from `begin` to `end`.
std::vector<events::Event> noise_and_marker(int marker, std::int64_t begin, std::int64_t end) {
  Random random(2);
  std::vector<events::Event> events;
  events.reserve(20'000 + static_cast<std::size_t>(marker));
  for (int i = 0; i < 20'000; ++i)
    events.push_back(event_at(static_cast<std::int64_t>(random.below(4'000'000)), static_cast<int>(random.below(64)),
                              static_cast<int>(random.below(48))));
  for (int i = 0; i < marker; ++i)
    events.push_back(event_at(begin + static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(end - begin))), 20, 20));
  return events;
}

TEST(TouchedPlaces, AreWhereTheRateRisesInAnInterval) {
  const TouchedPlaces places = places_of(with_press(), noise_and_marker(2'000, 1'000'000, 2'000'000));
  ASSERT_FALSE(places.empty());
  EXPECT_TRUE(places.contains(event_at(0, 20, 20)));
  int cells = 0;
  for (int y = 0; y < 48; y += 8)
    for (int x = 0; x < 64; x += 8) cells += places.contains(event_at(0, x, y)) ? 1 : 0;
  EXPECT_EQ(cells, 1) << "of 48: noise is no touch";
  EXPECT_FALSE(places.contains(event_at(0, 64, 20)));
  EXPECT_FALSE(places.contains(event_at(0, -1, 20)));
}

TEST(TouchedPlaces, WhatFiresAllTheTimeIsNoTouch) {
  const TouchedPlaces places = places_of(with_press(), noise_and_marker(8'000, 0, 4'000'000));
  EXPECT_FALSE(places.contains(event_at(0, 20, 20)));
}

TEST(TouchedPlaces, TheUncertainTimeAroundAnEndIsNotQuiet) {
  // All of the marker's events lie before the labelled start or after the end, inside their 95 % intervals: neither quiet nor
  // touch.
  labels::Labels labels = with_press();
  std::vector<events::Event> events;
  events.reserve(1'000);
  for (int i = 0; i < 900; ++i) events.push_back(event_at(955'000 + 40 * i, 20, 20));
  for (int i = 0; i < 100; ++i) events.push_back(event_at(1'100'000 + 1'000 * i, 20, 20));
  EXPECT_TRUE(places_of(labels, events).contains(event_at(0, 20, 20)));
  labels.intervals.front().start.low = labels.intervals.front().start.at;
  EXPECT_FALSE(places_of(labels, events).contains(event_at(0, 20, 20)));
}

TEST(TouchedPlaces, WithoutAnIntervalThereAreNone) {
  EXPECT_TRUE(places_of({}, noise_and_marker(2'000, 1'000'000, 2'000'000)).empty());
  EXPECT_TRUE(places_of(with_press(), {}).empty());
}

}  // namespace
}  // namespace tactile::review
