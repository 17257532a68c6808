#include "tactile/video/frame_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace tactile::video {
namespace {

constexpr std::int64_t none = -1;

/// The line of time, in ms, that a clock makes of the times of the source and the arrival of each frame, both in ms.
std::vector<std::int64_t> line_of(bool live, const std::vector<std::pair<double, std::int64_t>>& frames) {
  FrameClock clock(live, 40ms);
  std::vector<std::int64_t> line;
  for (const auto& [told_ms, came_ms] : frames) {
    const auto t = clock.time_of(told_ms, HostTime{std::chrono::milliseconds(came_ms)});
    line.push_back(t ? t->count() / 1000 : none);
  }
  return line;
}

using Line = std::vector<std::int64_t>;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(FrameClock, KeepsTheSourcesOwnStepsFromItsFirstFrameOn) {
  EXPECT_EQ(line_of(false, {{500, 0}, {533, 1}, {600, 2}}), (Line{0, 33, 100}));
  EXPECT_EQ(line_of(true, {{90'000, 10}, {90'033, 51}, {90'100, 90}}), (Line{0, 33, 100}));
}

TEST(FrameClock, LeavesOutDuplicatesOfAFile) {
  EXPECT_EQ(line_of(false, {{0, 0}, {33, 1}, {33, 2}, {30, 3}, {66, 4}}), (Line{0, 33, none, none, 66}));
  EXPECT_EQ(line_of(false, {{0, 0}, {0, 1}, {33, 2}}), (Line{0, none, 33}));
}

TEST(FrameClock, TakesTheRateOfAFileWithoutTimes) {
  EXPECT_EQ(line_of(false, {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}}), (Line{0, none, 40, 80, 120}));
  EXPECT_EQ(line_of(false, {{nan, 0}, {nan, 1}, {nan, 2}, {nan, 3}}), (Line{0, none, 40, 80}));
}

TEST(FrameClock, ContinuesWhereAFileRestartsOrLeapsAhead) {
  EXPECT_EQ(line_of(false, {{0, 0}, {5'000, 1}, {0, 2}, {33, 3}}), (Line{0, 5'000, 5'040, 5'073}));
  EXPECT_EQ(line_of(false, {{0, 0}, {33, 1}, {9e6, 2}, {9e6 + 33, 3}}), (Line{0, 33, 73, 106}));
  EXPECT_EQ(line_of(false, {{0, 0}, {33, 1}, {infinity, 2}}).size(), 3U);
  EXPECT_EQ(line_of(false, {{-1e308, 0}, {1e308, 1}}), (Line{0, none}));
}

TEST(FrameClock, TakesTheHostsStepsWhereALiveSourcesTimeIsImpossible) {
  EXPECT_EQ(line_of(true, {{0, 100}, {0, 133}, {0, 166}}), (Line{0, 33, 66})) << "it tells none";
  EXPECT_EQ(line_of(true, {{7'000, 100}, {7'033, 133}, {0, 166}, {30, 200}}), (Line{0, 33, 66, 96})) << "it begins again";
  EXPECT_EQ(line_of(true, {{0, 0}, {1e12, 33}, {1e12 + 30, 66}}), (Line{0, 33, 63})) << "it leaps ahead";
  EXPECT_EQ(line_of(true, {{nan, 0}, {nan, 33}, {5, 66}, {40, 99}}), (Line{0, 33, 66, 101}));
  EXPECT_EQ(line_of(true, {{0, 0}, {2'000, 1}, {2'033, 2}}), (Line{0, 2'000, 2'033})) << "frames that waited come at once";
}

TEST(FrameClock, KnowsWhetherAStepIsTheSourcesOwn) {
  FrameClock clock(true, 40ms);
  const auto is_own = [&](double source_ms, std::int64_t came_ms) {
    clock.time_of(source_ms, HostTime{std::chrono::milliseconds(came_ms)});
    return clock.is_own();
  };
  EXPECT_FALSE(is_own(7'000, 100)) << "the first frame has no step";
  EXPECT_TRUE(is_own(7'030, 133));
  EXPECT_FALSE(is_own(0, 166)) << "it begins again";
  EXPECT_TRUE(is_own(30, 200));
}

TEST(FrameClock, AscendsEvenWhereTheHostsTimeStandsStill) {
  FrameClock clock(true, 40ms);
  EXPECT_EQ(clock.time_of(0, HostTime{}), 0us);
  EXPECT_EQ(clock.time_of(0, HostTime{}), 1us);
  EXPECT_EQ(clock.time_of(0, HostTime{}), 2us);
}

}  // namespace
}  // namespace tactile::video
