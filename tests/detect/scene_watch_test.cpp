#include "tactile/detect/scene_watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "events/counted_memory.hpp"
#include "tactile/core/random.hpp"

namespace tactile::detect {
namespace {

constexpr events::SensorSize sensor{80, 60};
constexpr std::int64_t second = 1'000'000;

/// Uniform noise of so many events/s.
std::vector<events::Event> noise(double hz, std::int64_t from_us, std::int64_t to_us) {
  Random random(3);
  std::vector<events::Event> events;
  for (double t = static_cast<double>(from_us); t < static_cast<double>(to_us); t += random.exponential() * 1e6 / hz) {
    events.push_back({camera_time(static_cast<std::int64_t>(t)), static_cast<std::int16_t>(random.below(80)),
                      static_cast<std::int16_t>(random.below(60)), 1});
  }
  return events;
}

characterise::SceneRanges training() {
  characterise::SceneRanges ranges;
  ranges.add_run(std::vector<characterise::Scene>{{29'000, 0, 0, 0, 0.0}});
  ranges.add_run(std::vector<characterise::Scene>{{37'000, 0, 0, 0, 0.0}});
  return ranges;
}

struct Watched {
  std::vector<std::string> lines;
  SceneWatch watch;

  explicit Watched(bool at_once = true, microseconds pause = 0us)
      : watch({.sensor = sensor, .training = training(), .at_once = at_once, .pause = pause},
              [this](const characterise::SceneChange& change) { lines.push_back(change.text); }) {}
  /// Adds events by packets of up to 100, as they arrive.
  void add(const std::vector<events::Event>& events) {
    for (std::span<const events::Event> left(events); !left.empty(); left = left.subspan(std::min<std::size_t>(100, left.size())))
      watch.add(left.first(std::min<std::size_t>(100, left.size())));
  }
};

TEST(SceneWatch, MeasuresNoWindowThatLacksEvents) {
  Watched watched;
  const auto add_with_losses = [&](std::uint64_t lost_each_second) {
    for (std::int64_t s = 0; s < 6; ++s) {
      watched.add(noise(10'000, s * second, (s + 1) * second));
      watched.watch.lose(lost_each_second);
    }
    watched.watch.restart();
  };
  add_with_losses(20'000);
  EXPECT_TRUE(watched.lines.empty()) << "what is left looks like a quieter scene";
  EXPECT_GT(watched.watch.summary().skipped, 3U);
  EXPECT_LE(watched.watch.summary().windows, 1U) << "the first window was full before the first loss";
  add_with_losses(100);
  EXPECT_EQ(watched.lines.size(), 1U) << "1 % changes nothing";
}

TEST(SceneWatch, PrintsOneLineWhenTheSceneLeavesAndOneWhenItReturns) {
  Watched watched;
  watched.add(noise(33'000, 0, 3 * second));
  EXPECT_TRUE(watched.lines.empty());
  watched.add(noise(167'000, 3 * second, 8 * second));
  ASSERT_EQ(watched.lines.size(), 1U);
  EXPECT_TRUE(watched.lines[0].starts_with("background 16") && watched.lines[0].ends_with(" kev/s, training 29 to 37"))
      << watched.lines[0];
  EXPECT_TRUE(watched.watch.summary().is_outside);
  watched.add(noise(33'000, 8 * second, 12 * second));
  ASSERT_EQ(watched.lines.size(), 2U);
  EXPECT_TRUE(watched.lines[1].starts_with("as in training again, background 3")) << watched.lines[1];
  EXPECT_FALSE(watched.watch.summary().is_outside);
  EXPECT_EQ(watched.watch.summary().left, 1U);
  EXPECT_EQ(watched.watch.summary().returned, 1U);
}

TEST(SceneWatch, IsNotChangedByAPress) {
  Watched watched;
  std::vector<events::Event> events = noise(33'000, 0, 6 * second);
  for (std::int64_t begin = second / 2; begin < 6 * second; begin += second) {  // a press of 0.7 s in each second
    const std::vector<events::Event> press = noise(300'000, begin, begin + 700'000);
    events.insert(events.end(), press.begin(), press.end());
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  watched.add(events);
  watched.watch.finish();
  EXPECT_TRUE(watched.lines.empty()) << watched.lines.front();
  EXPECT_EQ(watched.watch.summary().windows, 6U);
}

TEST(SceneWatch, MeasuresALastWindowOfHalfASecond) {
  Watched watched;
  watched.add(noise(167'000, 0, second + 600'000));
  EXPECT_TRUE(watched.lines.empty()) << "one window may be covered by a touch";
  watched.watch.finish();
  EXPECT_EQ(watched.lines.size(), 1U);
  Watched shorter;
  shorter.add(noise(167'000, 0, second + 400'000));
  shorter.watch.finish();
  EXPECT_TRUE(shorter.lines.empty());
}

TEST(SceneWatch, PausesAfterAWindowThatAgreesOnly) {
  Watched watched(true, microseconds{3 * second});
  watched.add(noise(33'000, 0, 10 * second));
  EXPECT_EQ(watched.watch.summary().windows, 3U) << "[0, 1), [4, 5), [8, 9)";
  watched.add(noise(167'000, 10 * second, 20 * second));
  EXPECT_EQ(watched.lines.size(), 1U);
}

TEST(SceneWatch, AllocatesNoMemoryWhileItCollects) {
  Watched watched(false);
  const std::vector<events::Event> events = noise(33'000, 0, 3 * second);
  const std::size_t before = test::memory_requests;
  watched.add(events);
  EXPECT_EQ(test::memory_requests, before);
  EXPECT_EQ(watched.watch.summary().windows, 0U) << "another thread measures";
  watched.watch.look();
  EXPECT_EQ(watched.watch.summary().windows, 1U);
  watched.watch.look();
  EXPECT_EQ(watched.watch.summary().windows, 1U) << "it is empty";
}

TEST(SceneWatch, BeginsAgainAfterARestart) {
  Watched watched(true, microseconds{3 * second});
  watched.add(noise(33'000, 0, 2 * second));  // pauses until 4 s
  watched.watch.restart();
  watched.add(noise(33'000, 0, second + 100));
  EXPECT_EQ(watched.watch.summary().windows, 2U) << "its time went back";
  watched.watch.restart();
  watched.add(noise(33'000, 0, second / 2));
  watched.watch.restart();
  watched.add(noise(33'000, second / 2, second + 100));
  EXPECT_EQ(watched.watch.summary().windows, 2U) << "no window has events of two streams";
}

}  // namespace
}  // namespace tactile::detect
