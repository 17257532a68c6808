#include "tactile/core/clock_pairs.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "support/host_time.hpp"

namespace tactile {
namespace {

using test::host_time;

using CameraPairs = ClockPairs<CameraClock>;
using CameraPair = ClockPair<CameraClock>;

TEST(ClockPairs, KeepsThePairOfEachSecondThatCameFastest) {
  CameraPairs pairs;
  pairs.add({camera_time(100), host_time(5'000'900)});  // 5'000'800 apart
  pairs.add({camera_time(200), host_time(5'000'950)});  // 5'000'750
  pairs.add({camera_time(300), host_time(5'001'200)});
  pairs.add({camera_time(1'000'000), host_time(6'000'700)});  // 5'000'700, a second later
  pairs.add({camera_time(1'100'000), host_time(6'900'000)});
  EXPECT_EQ(pairs.pairs(),
            (std::vector<CameraPair>{{camera_time(200), host_time(5'000'950)}, {camera_time(1'000'000), host_time(6'000'700)}}));
}

TEST(ClockPairs, StaysBoundedAndKeepsTheFastestOfLongerStretches) {
  CameraPairs pairs(8);
  for (std::int64_t second = 0; second < 1000; ++second) {
    const std::int64_t late_us = second % 10 == 3 ? 5 : 100;
    pairs.add({camera_time(second * 1'000'000), host_time(second * 1'000'000 + late_us)});
  }
  ASSERT_GE(pairs.pairs().size(), 4U);
  EXPECT_LE(pairs.pairs().size(), 8U);
  for (const CameraPair& pair : pairs.pairs()) EXPECT_EQ(us_of(pair.host) - us_of(pair.device), 5);
}

TEST(ClockPairs, StandsTimesAtTheEndsOfTheClock) {
  CameraPairs pairs;
  pairs.add({CameraTime::min(), host_time(1)});
  pairs.add({CameraTime::max(), host_time(2)});
  ASSERT_EQ(pairs.pairs().size(), 1U);
  EXPECT_EQ(pairs.pairs().front().device, CameraTime::max());
}

TEST(ClockPairs, ReportHowFarTheCamerasClockHasMoved) {
  CameraPairs pairs;
  EXPECT_FALSE(pairs.offset());
  pairs.add({camera_time(100), host_time(1'000'400)});
  EXPECT_EQ(pairs.offset()->offset, microseconds{1'000'300});
  EXPECT_EQ(pairs.offset()->change, microseconds{0});
  // 50 us slower in each second; single packets come late.
  for (std::int64_t ms = 1; ms < 20'000; ++ms)
    pairs.add({camera_time(100 + 1'000 * ms), host_time(1'000'400 + 1'000 * ms + ms / 20 + (ms % 7 == 0 ? 3'000 : 0))});
  const ClockOffset moved = *pairs.offset();
  EXPECT_NEAR(static_cast<double>(moved.change.count()), 50e-6 * static_cast<double>(moved.span.count()), 60);
  EXPECT_NEAR(static_cast<double>(moved.span.count()), 18.5e6, 1e6);
  EXPECT_EQ(moved.offset - moved.change, microseconds{1'000'300});
}

}  // namespace
}  // namespace tactile
