#include "tactile/labels/onset.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "labels/rate_of.hpp"

namespace tactile {
namespace {

struct OnsetErrors {
  std::vector<double> errors_ms;  ///< absolute, ascending
  int covered = 0;
};

OnsetErrors errors_over_seeds(const std::function<double(double)>& rise, int seeds) {
  constexpr double onset_us = 400'100;
  const CameraTime onset = camera_time(1'000'000 + 400'100);
  OnsetErrors result;
  for (int seed = 0; seed < seeds; ++seed) {
    const EventRate rate = test::rate_of(
        5'000, [&](double t_us) { return 3.0 + (t_us < onset_us || t_us > onset_us + 200'000 ? 0.0 : rise(t_us - onset_us)); },
        static_cast<std::uint64_t>(seed));
    const UncertainTime found = onset_near(rate, quiet_rate(rate), 2'030);
    result.errors_ms.push_back(std::abs(static_cast<double>(between(onset, found.at).count())) / 1000.0);
    result.covered += found.low <= onset && onset <= found.high ? 1 : 0;
  }
  std::sort(result.errors_ms.begin(), result.errors_ms.end());
  return result;
}

TEST(Onset, OfABlowIsFoundToTheReadOut) {
  const OnsetErrors found = errors_over_seeds([](double) { return 30.0; }, 100);
  EXPECT_LE(found.errors_ms[50], 0.3);
  EXPECT_LE(found.errors_ms[95], 0.7);
  EXPECT_GE(found.covered, 90);
}

TEST(Onset, OfAStartFromRestIsFoundToMilliseconds) {
  const OnsetErrors found = errors_over_seeds([](double u_us) { return u_us * 0.004; }, 100);
  EXPECT_LE(found.errors_ms[50], 1.0);
  EXPECT_LE(found.errors_ms[95], 3.0);
  EXPECT_GE(found.covered, 88);
}

TEST(Onset, IsKeptInsideTheRecordingNearItsBegin) {
  const EventRate rate = test::rate_of(
      300, [](double t_us) { return t_us < 4'000 ? 3.0 : 50.0; }, 1);
  const UncertainTime found = onset_near(rate, {.mean = 3.0, .dispersion = 1.0}, 25);
  EXPECT_NEAR(static_cast<double>(between(rate.begin, found.at).count()), 4'000, 400);
}

}  // namespace
}  // namespace tactile
