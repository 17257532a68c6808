#include "tactile/simulation/fast_log.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace tactile::simulation {
namespace {

/// The error relative to the logarithm itself, also near 1.
double error_of(float x, float found) {
  const double truth = std::log(static_cast<double>(x));
  return std::abs(static_cast<double>(found) - truth) / std::max(std::abs(truth), 1e-30);
}

TEST(TakeLogs, IsAccurateToFloatForEveryNormalNumber) {
  // Every exponent, and mantissas that are spread evenly.
  std::vector<float> values;
  for (std::uint32_t bits = 0x0080'0000; bits < 0x7f80'0000; bits += 0x0000'9abd) values.push_back(std::bit_cast<float>(bits));
  std::vector<float> logs = values;
  take_logs(logs.data(), logs.size());
  double worst = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] != 1.0F) worst = std::max(worst, error_of(values[i], logs[i]));
  }
  EXPECT_LT(worst, 5e-7) << "float has steps of 1.2e-7";
}

TEST(TakeLogs, IsAccurateToFloatAroundOne) {
  for (float x = 0.9F; x < 1.1F; x = std::nextafter(x, 2.0F) + 1e-6F) ASSERT_LT(error_of(x, log_of(x)), 5e-7) << x;
  EXPECT_EQ(log_of(1.0F), 0.0F);
  const float next = std::nextafter(1.0F, 2.0F);
  EXPECT_NEAR(log_of(next) / (next - 1.0F), 1, 1e-5);
}

TEST(TakeLogs, IsFiniteAtTheEndsOfNormalNumbers) {
  EXPECT_NEAR(log_of(std::numeric_limits<float>::min()), -87.3365, 1e-3);
  EXPECT_NEAR(log_of(std::numeric_limits<float>::max()), 88.7228, 1e-3);
}

}  // namespace
}  // namespace tactile::simulation
