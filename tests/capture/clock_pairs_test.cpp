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

}  // namespace
}  // namespace tactile::capture
