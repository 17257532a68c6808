#include "tactile/review/signal_window.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tactile::review {
namespace {

constexpr float gap = std::numeric_limits<float>::quiet_NaN();

SampledSignal signal_of(std::vector<std::int64_t> t_us, std::vector<float> values) {
  return {.name = "speed", .unit = "m/s", .label = "Speed", .t_us = std::move(t_us), .values = std::move(values)};
}

TEST(SignalWindow, FewSamplesAreThemselvesWithTheirNeighbours) {
  const SampledSignal signal = signal_of({0, 10, 20, 30, 40}, {1, 2, 3, 4, 5});
  const SignalWindow window = window_of(signal, {.from_us = 15, .to_us = 30, .points = 100});
  EXPECT_EQ(window.bucket_us, 0);
  EXPECT_EQ(window.t_us, (std::vector<std::int64_t>{10, 20, 30}));
  EXPECT_EQ(window.mean, (std::vector<double>{2, 3, 4}));
  EXPECT_EQ(window.least, window.mean);
  EXPECT_EQ(window.most, window.mean);
}

TEST(SignalWindow, ManySamplesBecomeBucketsWithLeastMeanAndMost) {
  const SampledSignal signal = signal_of({0, 10, 20, 30, 40, 50}, {1, 5, 3, -2, 4, 4});
  const SignalWindow window = window_of(signal, {.from_us = 0, .to_us = 60, .points = 2});
  EXPECT_EQ(window.bucket_us, 30);
  EXPECT_EQ(window.t_us, (std::vector<std::int64_t>{15, 45}));
  EXPECT_EQ(window.least, (std::vector<double>{1, -2}));
  EXPECT_EQ(window.mean, (std::vector<double>{3, 2}));
  EXPECT_EQ(window.most, (std::vector<double>{5, 4}));
}

TEST(SignalWindow, ABucketBeforeTheFirstEventIsOfItsOwn) {
  const SampledSignal signal = signal_of({-3, -2, -1, 0, 1, 2}, {1, 1, 1, 9, 9, 9});
  const SignalWindow window = window_of(signal, {.from_us = -3, .to_us = 3, .points = 2});
  EXPECT_EQ(window.mean, (std::vector<double>{1, 9}));
}

TEST(SignalWindow, GapsAreNullAndNoPartOfABucketsMean) {
  const SampledSignal signal = signal_of({0, 1, 2, 3, 4, 5}, {2, gap, 4, gap, gap, gap});
  const SignalWindow window = window_of(signal, {.from_us = 0, .to_us = 6, .points = 2});
  EXPECT_EQ(window.mean.at(0), 3);
  EXPECT_TRUE(std::isnan(window.mean.at(1)));
  const nlohmann::json json = json_of(window);
  EXPECT_TRUE(json.at("mean").at(1).is_null());
  EXPECT_EQ(json.at("min").at(0), 2);
  EXPECT_EQ(json.at("max").at(0), 4);
}

TEST(SignalWindow, WithoutSamplesIsEmpty) {
  EXPECT_TRUE(window_of(signal_of({}, {}), {.from_us = 0, .to_us = 10, .points = 5}).t_us.empty());
}

TEST(WindowRequest, ItsBucketsAreWholeUnitsThatCoverIt) {
  EXPECT_EQ((WindowRequest{.from_us = 0, .to_us = 1000, .points = 10}).bucket_us(1), 100);
  EXPECT_EQ((WindowRequest{.from_us = 0, .to_us = 1001, .points = 10}).bucket_us(1), 101);
  EXPECT_EQ((WindowRequest{.from_us = 0, .to_us = 1001, .points = 10}).bucket_us(100), 200);
  EXPECT_EQ((WindowRequest{.from_us = 5, .to_us = 6, .points = 10}).bucket_us(1), 1);
}

}  // namespace
}  // namespace tactile::review
