#include "tactile/capture/clock_pairs.hpp"

#include <gtest/gtest.h>

namespace tactile::capture {
namespace {

HostTime host(std::int64_t us) { return HostTime{microseconds{us}}; }

TEST(ClockPairs, KeepsThePairOfEachSecondThatCameFastest) {
  ClockPairs pairs;
  pairs.add(camera_time(100), host(5'000'900));  // 5'000'800 apart
  pairs.add(camera_time(200), host(5'000'950));  // 5'000'750
  pairs.add(camera_time(300), host(5'001'200));
  pairs.add(camera_time(1'000'000), host(6'000'700));  // 5'000'700, a second later
  pairs.add(camera_time(1'100'000), host(6'900'000));
  EXPECT_EQ(pairs.pairs(),
            (std::vector<ClockPair>{{camera_time(200), host(5'000'950)}, {camera_time(1'000'000), host(6'000'700)}}));
}

TEST(ClockPairs, StaysBoundedAndKeepsTheFastestOfLongerStretches) {
  ClockPairs pairs(8);
  for (std::int64_t second = 0; second < 1000; ++second) {
    const std::int64_t late_us = second % 10 == 3 ? 5 : 100;
    pairs.add(camera_time(second * 1'000'000), host(second * 1'000'000 + late_us));
  }
  ASSERT_GE(pairs.pairs().size(), 4U);
  EXPECT_LE(pairs.pairs().size(), 8U);
  for (const ClockPair& pair : pairs.pairs()) EXPECT_EQ(us_of(pair.host) - us_of(pair.camera), 5);
}

TEST(ClockPairs, StandsTimesAtTheEndsOfTheClock) {
  ClockPairs pairs;
  pairs.add(CameraTime::min(), host(1));
  pairs.add(CameraTime::max(), host(2));
  ASSERT_EQ(pairs.pairs().size(), 1U);
  EXPECT_EQ(pairs.pairs().front().camera, CameraTime::max());
}

TEST(ClockPairs, SayHowFarTheCamerasClockHasMoved) {
  ClockPairs pairs;
  EXPECT_FALSE(pairs.offset());
  pairs.add(camera_time(100), host(1'000'400));
  EXPECT_EQ(pairs.offset()->offset, microseconds{1'000'300});
  EXPECT_EQ(pairs.offset()->change, microseconds{0});
  // 50 us slower in each second; single packets come late.
  for (std::int64_t ms = 1; ms < 20'000; ++ms)
    pairs.add(camera_time(100 + 1'000 * ms), host(1'000'400 + 1'000 * ms + ms / 20 + (ms % 7 == 0 ? 3'000 : 0)));
  const ClockOffset moved = *pairs.offset();
  EXPECT_NEAR(static_cast<double>(moved.change.count()), 50e-6 * static_cast<double>(moved.span.count()), 60);
  EXPECT_NEAR(static_cast<double>(moved.span.count()), 18.5e6, 1e6);
  EXPECT_EQ(moved.offset - moved.change, microseconds{1'000'300});
}

TEST(RecentLateness, IsTheMostOfTheLastTenthsOfASecond) {
  RecentLateness recent;
  const auto at = [&](std::int64_t ms, std::int64_t late_us) {
    recent.add(host(1'000 * ms), microseconds{late_us});
    return recent.most(host(1'000 * ms)).count();
  };
  EXPECT_EQ(at(1'000, 5), 5);
  EXPECT_EQ(at(1'050, 900), 900);
  EXPECT_EQ(at(1'110, 7), 900) << "of the window before";
  EXPECT_EQ(at(1'220, 3), 7);
  EXPECT_EQ(at(5'000, 1), 1) << "what was before a silence is over";
  EXPECT_EQ(recent.most(host(5'250'000)).count(), 0) << "and during it, too";
}

}  // namespace
}  // namespace tactile::capture
