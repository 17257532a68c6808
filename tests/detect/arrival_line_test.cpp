#include "tactile/detect/arrival_line.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/host_time.hpp"
#include "tactile/core/random.hpp"

namespace tactile::detect {
namespace {

using test::host_time;

constexpr std::int64_t base = 1'700'000'000'000'000;

TEST(ArrivalLine, LiesBelowEveryArrivalAndFollowsTheDriftBetweenTwoClocks) {
  ArrivalLine line;
  Random random(3);
  // The camera's clock runs 60 ppm slow; packets take 300 us and an exponential of 1 ms more.
  for (std::int64_t t = 0; t < 30'000'000; t += 1000) {
    const auto delay = static_cast<std::int64_t>(300 + 1000 * random.exponential());
    const auto drifted = static_cast<std::int64_t>(60e-6 * static_cast<double>(t));
    line.add(camera_time(5'000 + t), host_time(base + t + drifted + delay));
    if (t > 100'000) {
      EXPECT_LE(us_of(line.host_of(camera_time(5'000 + t))), base + t + drifted + delay + 1) << t;
    }
  }
  EXPECT_NEAR(line.drift_ppm(), 60, 10);
  const std::int64_t next = 30'000'000;
  EXPECT_NEAR(static_cast<double>(us_of(line.host_of(camera_time(5'000 + next))) - base), next + 1800 + 300, 60);
  EXPECT_NEAR(static_cast<double>(us_of(line.camera_of(line.host_of(camera_time(123'456))))), 123'456, 2);
}

TEST(ArrivalLine, GoesDownAtOnceWhereAnArrivalIsEarlierThanEver) {
  ArrivalLine line;
  line.add(camera_time(0), host_time(base + 2'000'000));  // held back on its way
  EXPECT_EQ(us_of(line.host_of(camera_time(1'000'000))), base + 3'000'000);
  line.add(camera_time(2'000'000), host_time(base + 2'000'400));
  EXPECT_EQ(us_of(line.host_of(camera_time(2'000'000))), base + 2'000'400);
}

TEST(ArrivalLine, ForgetsWhatIsTenSecondsOld) {
  ArrivalLine line;
  for (std::int64_t t = 0; t < 40'000'000; t += 10'000) {
    const std::int64_t delay = t < 5'000'000 ? 100 : 700;  // another way, from then on
    line.add(camera_time(t), host_time(base + t + delay));
  }
  EXPECT_EQ(us_of(line.host_of(camera_time(40'000'000))) - base, 40'000'700);
}

TEST(ArrivalLine, HoldsAtTheEndsOfBothClocks) {
  constexpr std::int64_t lowest = std::numeric_limits<std::int64_t>::min(), highest = std::numeric_limits<std::int64_t>::max();
  ArrivalLine line;
  line.add(camera_time(highest - 1000), host_time(base));
  line.add(camera_time(highest), host_time(base + 1000));
  EXPECT_GE(us_of(line.host_of(camera_time(highest))), base);
  EXPECT_LT(us_of(line.host_of(camera_time(lowest))), 0);
  EXPECT_EQ(us_of(line.camera_of(host_time(highest))), highest);
  line.restart();
  EXPECT_FALSE(line.is_known());
  line.add(camera_time(lowest), host_time(base));
  EXPECT_EQ(us_of(line.host_of(camera_time(lowest + 500))), base + 500);
}

TEST(ArrivalLine, ForgetsWhatIsAllOfTheHostsTimeOld) {
  constexpr std::int64_t highest = std::numeric_limits<std::int64_t>::max();
  ArrivalLine line;
  line.add(camera_time(0), host_time(-5));  // far below all that follows
  line.add(camera_time(1'000), host_time(highest));
  EXPECT_GT(us_of(line.host_of(camera_time(1'000))), highest / 2);
}

TEST(ArrivalLine, KnowsTheMicrosecondAfterAYear) {
  constexpr std::int64_t year = 365 * std::int64_t{86'400'000'000};
  ArrivalLine line;
  line.add(camera_time(0), host_time(base));
  // 150 ppm from the first arrival on: the clocks are 79 minutes apart by then.
  const auto host_at = [](std::int64_t t) { return base + t + t / 20'000 * 3; };
  for (std::int64_t t = year; t <= year + 20'000'000; t += 20'000) line.add(camera_time(t), host_time(host_at(t)));
  EXPECT_NEAR(line.drift_ppm(), 150, 0.01);
  for (std::int64_t t = year + 19'000'000; t <= year + 21'000'000; t += 20'000) {
    EXPECT_NEAR(static_cast<double>(us_of(line.host_of(camera_time(t))) - host_at(t)), 0, 2) << t - year;
    EXPECT_NEAR(static_cast<double>(us_of(line.camera_of(host_time(host_at(t)))) - t), 0, 2) << t - year;
  }
}

}  // namespace
}  // namespace tactile::detect
