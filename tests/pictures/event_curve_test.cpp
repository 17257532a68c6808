#include "tactile/pictures/event_curve.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "windows/made_runs.hpp"

namespace tactile::pictures {
namespace {

std::vector<events::Event> events_at(const std::vector<std::int64_t>& times_us) {
  std::vector<events::Event> events(times_us.size());
  for (std::size_t i = 0; i < events.size(); ++i) events[i].t = camera_time(times_us[i]);
  return events;
}

using Counts = std::vector<std::uint64_t>;
Counts counts_of(const EventCurve& curve) { return {curve.counts().begin(), curve.counts().end()}; }

TEST(EventCurve, CountsEventsInHalfOpenBinsFromItsStart) {
  EventCurve curve(camera_time(1000), 100us, 8);
  curve.add(events_at({999, 1000, 1000, 1099, 1100, 1350}));
  EXPECT_EQ(counts_of(curve), (Counts{3, 1, 0, 1}));
}

TEST(EventCurve, MakesLongerBinsOfNeighboursRatherThanMoreBins) {
  EventCurve curve(camera_time(0), 10us, 4);
  curve.add(events_at({0, 10, 20, 39}));
  EXPECT_EQ(counts_of(curve), (Counts{1, 1, 1, 1}));
  curve.add(events_at({40}));
  EXPECT_EQ(curve.bin(), 20us);
  EXPECT_EQ(counts_of(curve), (Counts{2, 2, 1}));
  curve.add(events_at({100'000}));
  EXPECT_LE(curve.counts().size(), 4U);
  EXPECT_EQ(std::accumulate(curve.counts().begin(), curve.counts().end(), std::uint64_t{0}), 6U);
  EventCurve widest(CameraTime::min(), 1us, 2);
  widest.add(events_at({std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}));
  EXPECT_EQ(std::accumulate(widest.counts().begin(), widest.counts().end(), std::uint64_t{0}), 2U);
}

TEST(EventCurve, GivesTheHighestRateOfAStretch) {
  EventCurve curve(camera_time(0), 500us);
  curve.add(events_at({0, 1, 2, 600, 1700}));
  EXPECT_EQ(curve.most_per_ms(camera_time(0), camera_time(500)), 6);
  EXPECT_EQ(curve.most_per_ms(camera_time(500), camera_time(1000)), 2);
  EXPECT_EQ(curve.most_per_ms(camera_time(499), camera_time(1000)), 6) << "bins that only overlap count";
  EXPECT_EQ(curve.most_per_ms(camera_time(1000), camera_time(1500)), 0);
  EXPECT_EQ(curve.most_per_ms(camera_time(-900), camera_time(0)), 0);
  EXPECT_EQ(curve.most_per_ms(camera_time(-900), camera_time(1)), 6);
  EXPECT_EQ(curve.most_per_ms(camera_time(5000), camera_time(9000)), 0);
  EXPECT_EQ(curve.most_per_ms(camera_time(100), camera_time(100)), 0);
}

TEST(EventCurve, LosesNoEvent) {
  const std::vector<events::Event> events = test::random_events({.length_us = 3'000'000});
  EventCurve curve(events.front().t, 10us, 64);
  for (std::size_t i = 0; i < events.size(); i += 777)
    curve.add(std::span(events).subspan(i, std::min<std::size_t>(777, events.size() - i)));
  EXPECT_EQ(std::accumulate(curve.counts().begin(), curve.counts().end(), std::uint64_t{0}), events.size());
  EXPECT_LE(curve.counts().size(), 64U);
}

}  // namespace
}  // namespace tactile::pictures
