#include "tactile/features/tick_features.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tactile/core/error.hpp"

namespace tactile::features {
namespace {

constexpr events::SensorSize sensor{640, 480};

using Window = std::array<float, features_of_window>;

Window features_of(const EventSums& sums) {
  Window features{};
  window_features(sums, sensor, features);
  return features;
}

void add(EventSums& sums, std::uint64_t x, std::uint64_t y, std::size_t on, std::uint32_t times = 1) {
  EventSums::OfPolarity& of = sums.of[on];
  of.events += times, of.x += times * x, of.y += times * y;
  of.xx += times * x * x, of.yy += times * y * y, of.xy += times * x * y;
  sums.cells[on][y * grid_rows / 480 * grid_columns + x * grid_columns / 640] += times;
}

TEST(WindowFeatures, OfNoEventAreThoseOfTheMiddle) {
  const Window features = features_of({});
  const Window expected{0, 0.5F, 0.5F, 0.5F, 0, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_TRUE(std::equal(features.begin(), features.begin() + 12, expected.begin()));
  for (std::size_t i = 12; i < features.size(); ++i) EXPECT_FLOAT_EQ(features[i], 1.0F / 9);
}

TEST(WindowFeatures, OfTwoEventsAreTheirsByHand) {
  EventSums sums;
  add(sums, 160, 120, 0);  // a quarter of both sides: the first field
  add(sums, 480, 360, 1);  // three quarters: the last field
  const Window features = features_of(sums);
  const std::vector<double> expected{
      std::log(3.0), 1.5 / 3, 0.5, 0.5, 0.25, 0.25, 0.0625, 0.5, 0.5, 2 * (9 - 1) / 16.0, 4.0 / 2 / 432, std::log(2.0),
      0.5,           0,       0,   0,   0,    0,    0,      0,   0.5};
  for (std::size_t i = 0; i < features.size(); ++i) EXPECT_NEAR(features[i], expected[i], 1e-7) << i;
}

TEST(WindowFeatures, AreFiniteAndInTheirRangesForEveryInput) {
  std::vector<EventSums> inputs(5);
  add(inputs[0], 0, 0, 1);
  add(inputs[1], 639, 479, 0, std::numeric_limits<std::uint32_t>::max());  // one hot pixel
  for (std::size_t cell = 0; cell < grid_cells; ++cell) {                  // every cell alike, and very full
    for (std::size_t on = 0; on < 2; ++on) add(inputs[2], cell % 24 * 640 / 24, cell / 24 * 480 / 18, on, 1'000'000);
  }
  add(inputs[3], 0, 0, 0, 1'000'000), add(inputs[3], 639, 479, 1);
  for (const EventSums& sums : inputs) {
    const Window f = features_of(sums);
    EXPECT_TRUE(std::all_of(f.begin(), f.end(), [](float value) { return std::isfinite(value); }));
    EXPECT_GE(f[0], 0);
    EXPECT_GE(f[11], 0);
    EXPECT_GT(f[1], 0);
    EXPECT_LT(f[1], 1);
    for (const std::size_t i : {2U, 3U, 10U, 12U, 20U}) EXPECT_TRUE(f[i] >= 0 && f[i] <= 1) << i;
    for (const std::size_t i : {4U, 5U}) EXPECT_TRUE(f[i] >= 0 && f[i] <= 0.5F) << i;
    for (const std::size_t i : {7U, 8U}) EXPECT_LE(std::abs(f[i]), 1) << i;
    EXPECT_LE(std::abs(f[6]), 0.25F);
    EXPECT_LE(std::abs(f[9]), 2);
  }
}

TEST(TickFeatures, AreThoseOfTheQuartersAndDoNotDependOnTheBins) {
  std::vector<events::Event> events;
  for (int i = 0; i < 4'000; ++i)
    events.push_back({camera_time(i * 2), static_cast<std::int16_t>(i * 7919 % 640), static_cast<std::int16_t>(i * 104'729 % 480),
                      static_cast<std::uint8_t>(i % 3 == 0 ? 1 : 0)});
  std::vector<TickFeatures> found;
  for (const microseconds bin : {2'000us, 500us}) {
    SlidingSums sums(sensor, 8ms, bin);
    sums.add(events);
    sums.move_to(camera_time(8'000));
    found.push_back(tick_features(sums, sensor));
  }
  EXPECT_EQ(found[0], found[1]);
  EventSums second;
  for (const events::Event& event : events) {
    if (us_of(event.t) >= 2'000 && us_of(event.t) < 4'000)
      add(second, static_cast<std::uint64_t>(event.x), static_cast<std::uint64_t>(event.y), event.on);
  }
  const Window expected = features_of(second);
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), found[0].begin() + features_of_window));
}

TEST(FeatureBin, DividesTheTickAndAQuarterOfTheHistory) {
  EXPECT_EQ(feature_bin(2ms, 40ms), 2ms);
  EXPECT_EQ(feature_bin(2ms, 50ms), 500us);
  EXPECT_EQ(feature_bin(2ms, 2ms), 500us);
  EXPECT_EQ(feature_bin(4ms, 40ms), 2ms);
  EXPECT_EQ(feature_bin(2ms, 1'002us), std::nullopt);
  EXPECT_EQ(feature_bin(7us, 700ms + 28us), std::nullopt);  // 100 004 bins of 7 us
  EXPECT_THROW(feature_bin(0us, 40ms), Error);
}

}  // namespace
}  // namespace tactile::features
