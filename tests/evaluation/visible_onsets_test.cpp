#include <gtest/gtest.h>

#include "tactile/evaluation/run_truth.hpp"

namespace tactile::evaluation {
namespace {

TouchInterval touch(Touch kind, std::int64_t start_us, std::int64_t end_us) {
  return {kind, camera_time(start_us), camera_time(end_us)};
}

TEST(VisibleOnsets, ReplaceThoseOfLabelsAndOfTheirTruth) {
  RunTruth truth;
  truth.labels = {{touch(Touch::press, 1'000, 9'000), true}, {touch(Touch::slip, 20'000, 30'000), true}};
  truth.visible = {camera_time(3'000), std::nullopt};
  truth.true_ones = {touch(Touch::press, 1'500, 8'000), touch(Touch::slip, 21'000, 30'000)};
  const RunTruth seen = with_visible_onsets(truth);
  EXPECT_EQ(seen.labels[0].interval.start, camera_time(3'000));
  EXPECT_EQ(seen.true_ones[0].start, camera_time(3'000));
  EXPECT_EQ(seen.labels[1].interval.start, camera_time(20'000)) << "it shows at no time";
  EXPECT_EQ(seen.true_ones[1].start, camera_time(21'000));
}

TEST(VisibleOnsets, LeaveNoTouchEmptyAndNoneEarlier) {
  RunTruth truth;
  truth.labels = {{touch(Touch::press, 1'000, 9'000), true}, {touch(Touch::slip, 20'000, 30'000), true}};
  truth.visible = {camera_time(8'500), camera_time(19'000)};
  truth.true_ones = {touch(Touch::press, 1'500, 8'000), touch(Touch::slip, 21'000, 30'000)};
  const RunTruth seen = with_visible_onsets(truth);
  EXPECT_EQ(seen.true_ones[0].start, camera_time(1'500));
  EXPECT_EQ(seen.labels[1].interval.start, camera_time(20'000));
  EXPECT_EQ(seen.true_ones[1].start, camera_time(21'000));
}

}  // namespace
}  // namespace tactile::evaluation
