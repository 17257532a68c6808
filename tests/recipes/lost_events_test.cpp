#include <gtest/gtest.h>

#include <set>

#include "hand_made_events.hpp"

namespace tactile::recipes {
namespace {

using events::Event;
using test::after_recipe;
using test::event;

constexpr events::SensorSize lossy_sensor{16, 12};

TEST(Loss, LosesItsShareAndMoreContainsLess) {
  const auto events = test::random_events(20'000, lossy_sensor);
  EXPECT_TRUE(after_recipe("loss:100", events).empty());
  const auto kept = after_recipe("loss:30", events), fewer = after_recipe("loss:60", events);
  EXPECT_NEAR(static_cast<double>(kept.size()), 14'000, 350);
  EXPECT_NEAR(static_cast<double>(fewer.size()), 8000, 350);
  std::set<std::int64_t> times;
  for (const Event& e : kept) times.insert(us_of(e.t));
  for (const Event& e : fewer) EXPECT_TRUE(times.contains(us_of(e.t)));
}

TEST(BurstLoss, LosesItsShareInBurstsOfItsLength) {
  const auto events = test::random_events(200'000, lossy_sensor, 50);  // 10 s
  EXPECT_TRUE(after_recipe("burst-loss:100", events).empty());
  const auto kept = after_recipe("burst-loss:40:burst_ms=5", events);
  EXPECT_NEAR(static_cast<double>(kept.size()) / 200'000, 0.6, 0.06);
  int bursts = 0;
  for (std::size_t i = 1; i < kept.size(); ++i) bursts += between(kept[i - 1].t, kept[i].t) > 50us ? 1 : 0;
  EXPECT_NEAR(bursts, 10.0 / (0.005 / 0.4), 120) << "a burst of 5 ms each 12.5 ms in the mean";
}

TEST(PacketLoss, LosesWholePacketsOfItsLengthFromTheFirstEvent) {
  const auto events = test::random_events(20'000, lossy_sensor, 100, 12'345);  // 2 s: 200 packets of 100 events
  const auto kept = after_recipe("packet-loss:40", events);
  std::map<std::int64_t, int> counts;
  for (const Event& e : kept) ++counts[(us_of(e.t) - 12'345) / 10'000];
  EXPECT_NEAR(static_cast<double>(counts.size()), 120, 30);
  for (const auto& [packet, count] : counts) EXPECT_EQ(count, 100) << packet;
}

TEST(ReadoutLimit, KeepsWhatItsQueueTakesAndLosesTheLastOfABurst) {
  std::vector<Event> burst;
  burst.reserve(20);
  for (int i = 0; i < 10; ++i) burst.push_back(event(0, i));
  for (int i = 0; i < 10; ++i) burst.push_back(event(2, i));
  // An event takes 1 us and the queue holds 4 us of work: 4 of the first ten, 2 us later 2 more.
  const auto kept = after_recipe("readout-limit:1000:queue_us=4", burst);
  const std::vector<Event> expected{event(0, 0), event(0, 1), event(0, 2), event(0, 3), event(2, 0), event(2, 1)};
  EXPECT_EQ(kept, expected);
}

TEST(ReadoutLimit, LosesNothingBelowItsRateAndPassesItsRateAbove) {
  const auto events = test::random_events(20'000, lossy_sensor, 10);  // 0.1 Mev/s
  EXPECT_EQ(after_recipe("readout-limit:9999", events), events);
  EXPECT_NEAR(static_cast<double>(after_recipe("readout-limit:20000", events).size()), 10'000, 60);
}

TEST(DeadLines, SilenceWholeRowsAndColumnsAndMoreContainFewer) {
  std::vector<Event> every_pixel;
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 16; ++x) every_pixel.push_back(event(y * 16 + x, x, y));
  }
  const auto rows = [&](std::string_view recipe) {
    std::set<int> alive;
    for (const Event& e : after_recipe(recipe, every_pixel)) alive.insert(e.y);
    return alive;
  };
  EXPECT_EQ(after_recipe("dead-rows:3", every_pixel).size(), 9U * 16U);
  EXPECT_EQ(after_recipe("dead-columns:5", every_pixel).size(), 11U * 12U);
  EXPECT_TRUE(after_recipe("dead-rows:12", every_pixel).empty());
  const auto three = rows("dead-rows:3");
  for (const int row : rows("dead-rows:6")) EXPECT_TRUE(three.contains(row));
}

}  // namespace
}  // namespace tactile::recipes
