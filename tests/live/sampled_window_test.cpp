#include "tactile/live/sampled_window.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace tactile::live {
namespace {

std::vector<events::Event> events_at(std::initializer_list<std::int64_t> times_us) {
  std::vector<events::Event> events;
  for (const std::int64_t t : times_us) events.push_back({.t = camera_time(t)});
  return events;
}

std::vector<std::int64_t> times_of(const SampledWindow& window) {
  std::vector<std::int64_t> times;
  for (const events::Event& event : window.events()) times.push_back(us_of(event.t));
  return times;
}

TEST(SampledWindow, CopiesNothingUnlessAWindowIsWanted) {
  SampledWindow window(10us, 100);
  window.add(events_at({0, 5, 50}));
  EXPECT_FALSE(window.is_full());
  EXPECT_TRUE(window.events().empty());
}

TEST(SampledWindow, HasTheEventsOfItsLengthFromTheNextEventOn) {
  SampledWindow window(10us, 100);
  window.want();
  window.add(events_at({100, 104}));
  EXPECT_FALSE(window.is_full());
  window.add(events_at({109, 110, 111}));
  ASSERT_TRUE(window.is_full());
  EXPECT_EQ(times_of(window), (std::vector<std::int64_t>{100, 104, 109}));
  EXPECT_EQ(window.end(), camera_time(110));
  EXPECT_EQ(window.length(), 10us);
  window.add(events_at({112}));  // no longer wanted
  EXPECT_EQ(window.events().size(), 3U);
}

TEST(SampledWindow, IsWantedAgainAndForgetsTheLastOne) {
  SampledWindow window(10us, 100);
  window.want();
  window.add(events_at({0, 10}));
  ASSERT_TRUE(window.is_full());
  window.put_back();
  window.want();
  window.add(events_at({20, 30}));
  ASSERT_TRUE(window.is_full());
  EXPECT_EQ(times_of(window), (std::vector<std::int64_t>{20}));
}

TEST(SampledWindow, EndsEarlierWithMoreEventsThanItHolds) {
  SampledWindow window(10us, 3);
  window.want();
  window.add(events_at({0, 1, 2, 2, 3}));
  ASSERT_TRUE(window.is_full());
  EXPECT_EQ(times_of(window), (std::vector<std::int64_t>{0, 1}));  // both events at 2, or none
  EXPECT_EQ(window.length(), 2us);
}

TEST(SampledWindow, BeginsAgainWhenTimeStepsBack) {
  SampledWindow window(10us, 100);
  window.want();
  window.add(events_at({100, 105}));
  window.add(events_at({3, 6}));
  window.add(events_at({13}));
  ASSERT_TRUE(window.is_full());
  EXPECT_EQ(times_of(window), (std::vector<std::int64_t>{3, 6}));
}

TEST(SampledWindow, IsHandedOverWholeBetweenTwoThreads) {
  SampledWindow window(50us, 1'000);
  std::atomic<bool> stops{false};
  std::thread adds([&] {
    for (std::int64_t t = 0; !stops; t += 5) window.add(events_at({t, t + 1, t + 2, t + 3, t + 4}));
  });
  for (int i = 0; i < 200; ++i) {
    window.want();
    while (!window.is_full()) std::this_thread::yield();
    const std::vector<std::int64_t> times = times_of(window);
    ASSERT_EQ(times.size(), 50U);
    for (std::size_t k = 1; k < times.size(); ++k) ASSERT_EQ(times[k], times[k - 1] + 1);
    window.put_back();
  }
  stops = true;
  adds.join();
}

}  // namespace
}  // namespace tactile::live
