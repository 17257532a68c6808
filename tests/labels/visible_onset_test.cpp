#include "tactile/labels/visible_onset.hpp"

#include <gtest/gtest.h>

namespace tactile::labels {
namespace {

CameraTime in_run(double ms) { return camera_time(std::llround(1000 * ms)); }

/// A second in bins of 200 us, with as many events in each as these are.
alignment::EventRate rate_with(std::uint32_t quiet, std::uint32_t from_500_ms, std::uint32_t from_510_ms) {
  alignment::EventRate rate{.begin = in_run(0), .counts = std::vector<std::uint32_t>(5'000, quiet), .last = in_run(1000)};
  std::fill(rate.counts.begin() + 2'500, rate.counts.end(), from_500_ms);
  std::fill(rate.counts.begin() + 2'550, rate.counts.end(), from_510_ms);
  return rate;
}

std::optional<CameraTime> visible(const alignment::EventRate& rate, double quiet, double end_ms = 900) {
  return visible_onset(rate, {.mean = quiet}, {in_run(500), in_run(495), in_run(502)}, in_run(end_ms));
}

TEST(VisibleOnset, IsWhereTheRateIsTwiceTheQuietOne) {
  // The first 10 ms have half as many events again: they are not seen. Three bins of the rise are enough for 2 ms.
  const auto found = visible(rate_with(10, 15, 40), 10);
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, in_run(508.6));
}

TEST(VisibleOnset, OfAQuietSensorNeedsFiveEvents) {
  EXPECT_FALSE(visible(rate_with(0, 0, 0), 0));
  alignment::EventRate few = rate_with(0, 0, 0);
  few.counts[2'600] = 4;
  EXPECT_FALSE(visible(few, 0));
  few.counts[2'605] = 1;
  EXPECT_EQ(visible(few, 0), in_run(520));
}

TEST(VisibleOnset, IsNothingIfItComesAfterTheEnd) { EXPECT_FALSE(visible(rate_with(10, 15, 40), 10, 507)); }

}  // namespace
}  // namespace tactile::labels
