#include "tactile/evaluation/detection_curve.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tactile/evaluation/detection_delay.hpp"

namespace tactile::evaluation {
namespace {

using results::Detection;
using results::DetectionOutcome;

Detection detected(std::int64_t ms) {
  return {.interval = {Touch::press, {}, {}}, .outcome = DetectionOutcome::detected, .delay = ms * 1ms, .limit = 500ms};
}
Detection missed(std::int64_t limit_ms) {
  return {.interval = {Touch::press, {}, {}}, .outcome = DetectionOutcome::missed, .limit = limit_ms * 1ms};
}
Detection early() {
  return {.interval = {Touch::press, {}, {}}, .outcome = DetectionOutcome::early, .limit = 500ms, .ahead = true};
}
Detection head_start() {
  Detection detection = detected(2);
  detection.ahead = true;
  return detection;
}

const RunsByObject one_run{{0}};

DetectionTimes times_of(std::vector<Detection> detections) {
  const std::vector<results::RunDetections> runs{{{"fan"}, std::move(detections)}};
  return {runs, Touch::press};
}

TEST(DetectionCurve, WithoutMissesIsTheShareDetected) {
  const DetectionTimes times = times_of({detected(4), detected(2), detected(10), detected(4)});
  EXPECT_DOUBLE_EQ(*times.share_within(one_run, 0), 0);
  EXPECT_DOUBLE_EQ(*times.share_within(one_run, 2), 0.25);
  EXPECT_DOUBLE_EQ(*times.share_within(one_run, 9.9), 0.75);
  EXPECT_DOUBLE_EQ(*times.share_within(one_run, 10), 1);
}

TEST(DetectionCurve, AgreesWithValuesOfSciPy) {
  // 1 - scipy.stats.ecdf(CensoredData(uncensored=[2, 4, 4, 8, 30, 30, 100, 320], right=[4, 20, 68, 68, 500])).sf.evaluate(t)
  const DetectionTimes times = times_of({missed(68), detected(4), detected(30), missed(500), detected(2), detected(8), missed(4),
                                         detected(4), detected(320), missed(20), detected(100), detected(30), missed(68)});
  const std::vector<std::pair<double, double>> by_scipy{{0, 0},
                                                        {2, 0.0769230769230769},
                                                        {4, 0.230769230769231},
                                                        {7, 0.230769230769231},
                                                        {8, 0.316239316239316},
                                                        {20, 0.316239316239316},
                                                        {30, 0.511599511599512},
                                                        {68, 0.511599511599512},
                                                        {100, 0.674399674399674},
                                                        {320, 0.837199837199837},
                                                        {900, 0.837199837199837}};
  for (const auto& [ms, share] : by_scipy) EXPECT_NEAR(*times.share_within(one_run, ms), share, 1e-12) << ms;
}

TEST(DetectionCurve, TakesAMissOutOfThoseLeftOnlyAfterItsLimit) {
  // At 10 ms two are left: the one that ended undetected at 4 ms says nothing of later times. The share is 1 - 1/2.
  EXPECT_DOUBLE_EQ(*times_of({missed(4), detected(10), missed(500)}).share_within(one_run, 10), 0.5);
  // At its own limit it is still there.
  EXPECT_DOUBLE_EQ(*times_of({missed(10), detected(10), missed(500)}).share_within(one_run, 10), 1.0 / 3);
}

TEST(DetectionCurve, HasThoseAheadOfTheOnsetAtZero) {
  const DetectionTimes times = times_of({early(), head_start(), detected(2), missed(500)});
  EXPECT_DOUBLE_EQ(*times.share_within(one_run, 0), 0.5);
  EXPECT_DOUBLE_EQ(*times.share_within(one_run, 2), 0.75);
}

TEST(DetectionCurve, CountsARunThatIsDrawnTwiceTwice) {
  const std::vector<results::RunDetections> runs{{{"fan"}, {detected(2)}}, {{"fan"}, {missed(500)}}};
  const DetectionTimes times(runs, Touch::press);
  EXPECT_DOUBLE_EQ(*times.share_within({{0, 0, 0, 1}}, 10), 0.75);
  EXPECT_DOUBLE_EQ(*times.missed_share({{0, 0, 0, 1}}), 0.25);
  EXPECT_EQ(times.quantile({{0, 0, 0, 1}}, 0.5)->ms, 2);
  EXPECT_EQ(times.quantile({{0, 1, 1, 1}}, 0.5)->ms, 500);
  EXPECT_FALSE(times.share_within({{}}, 10));
}

TEST(CensoredQuantile, IsOfAllIntervals) {
  const DetectionTimes times = times_of({detected(2), detected(4), detected(6), missed(500), missed(500)});
  EXPECT_EQ(times.quantile(one_run, 0.5)->ms, 6);
  EXPECT_FALSE(times.quantile(one_run, 0.5)->is_lower_bound);
  EXPECT_EQ(times.quantile(one_run, 0.9)->ms, 500);
  EXPECT_TRUE(times.quantile(one_run, 0.9)->is_lower_bound);
}

TEST(CensoredQuantile, IsALowerBoundWhereAShorterMissLiesBelowIt) {
  // The interval missed until 10 ms may have needed longer than 20 ms: then the median were longer.
  const auto median = times_of({missed(10), detected(20), detected(30)}).quantile(one_run, 0.5);
  EXPECT_EQ(median->ms, 20);
  EXPECT_TRUE(median->is_lower_bound);
  // A miss with a longer limit changes nothing.
  EXPECT_FALSE(times_of({detected(10), detected(20), missed(30)}).quantile(one_run, 0.5)->is_lower_bound);
}

TEST(DetectionLimit, IsTheEndOfTheIntervalOrTheWindow) {
  const TickRange ticks{CameraTime{}, 1000, 2ms};
  const std::vector<Touch> verdicts(1000, Touch::none);
  const std::vector<TouchInterval> intervals{{Touch::press, camera_time(5'000), camera_time(73'000)},
                                             {Touch::slip, camera_time(100'000), camera_time(900'000)}};
  const auto found = detections_of(ticks, verdicts, intervals);
  EXPECT_EQ(found[0].limit, 68ms);
  EXPECT_EQ(found[1].limit, 500ms);
  EXPECT_EQ(counted_from(found[1], camera_time(150'000), ticks).limit, 450ms);
}

TEST(DetectionLimit, ComesWithWhetherItWasAhead) {
  // Press from 20 ms on: 10 ms ahead of the first tick after its onset is a head start, further ahead is early.
  const TickRange ticks{CameraTime{}, 100, 2ms};
  std::vector<Touch> verdicts(100, Touch::press);
  std::fill(verdicts.begin(), verdicts.begin() + 10, Touch::none);
  const std::vector<TouchInterval> intervals{{Touch::press, camera_time(29'000), camera_time(90'000)},
                                             {Touch::press, camera_time(100'000), camera_time(150'000)}};
  const auto found = detections_of(ticks, verdicts, intervals);
  EXPECT_EQ(found[0].outcome, DetectionOutcome::detected);
  EXPECT_TRUE(found[0].ahead);
  EXPECT_EQ(found[1].outcome, DetectionOutcome::early);
  EXPECT_TRUE(found[1].ahead);
  EXPECT_FALSE(
      detections_of(ticks, verdicts, std::vector<TouchInterval>{{Touch::press, camera_time(19'000), camera_time(90'000)}})[0]
          .ahead);
}

TEST(DelayTable, KeepsMissesInMedianQuantileAndCurve) {
  std::vector<results::RunDetections> runs;
  for (const char* object : {"fan", "box", "hub"})
    runs.push_back({{object}, {detected(2), early(), head_start(), missed(500), missed(500)}});
  const results::DelayTable table = delay_table(runs, Touch::press);
  EXPECT_EQ(table.all.median_ms.value, 2) << "of those detected";
  EXPECT_EQ(table.all.median_of_all_ms.ms.value, 2);
  EXPECT_EQ(table.all.quantile_of_all_ms.ms.value, 500);
  EXPECT_TRUE(table.all.quantile_of_all_ms.is_lower_bound);
  EXPECT_DOUBLE_EQ(table.all.missed.value, 0.4);
  EXPECT_EQ(table.all.early, 3U);
  EXPECT_EQ(table.all.head_starts, 3U);
  ASSERT_FALSE(table.curve.empty());
  EXPECT_EQ(table.curve.front().ms, 0);
  EXPECT_DOUBLE_EQ(table.curve.front().share.value, 0.4);
  EXPECT_EQ(table.curve.back().ms, 500);
  EXPECT_DOUBLE_EQ(table.curve.back().share.value, 0.6);
  EXPECT_TRUE(table.curve.back().share.has_interval());
}

TEST(DelayTable, HasACurveThatOneLatePressDoesNotWiden) {
  // 298 presses of ten objects, all but one of which are detected within 50 ms. By SciPy: half is t of nine degrees, 2.69, times
  // the standard error of the objects' shares.
  std::vector<results::RunDetections> runs;
  for (int run = 0; run < 30; ++run) {
    const std::size_t presses = run < 2 ? 9 : 10;
    runs.push_back({{"object-" + std::to_string(run % 10)}, std::vector<Detection>(presses, detected(4))});
  }
  runs[5].detections[0] = detected(120);
  const auto curve = delay_table(runs, Touch::press).curve;
  const auto at_50 = std::find_if(curve.begin(), curve.end(), [](const results::DetectedWithin& at) { return at.ms == 50; });
  ASSERT_NE(at_50, curve.end());
  EXPECT_NEAR(at_50->share.value, 297.0 / 298, 1e-12);
  ASSERT_TRUE(at_50->share.has_interval());
  EXPECT_GT(*at_50->share.low, 0.96);
  EXPECT_LT(*at_50->share.high, 1);
}

TEST(DelayTable, HasACurveWhoseBoundsNeverFall) {
  // Nearly all are detected late, a few objects differ: pointwise intervals are widest where the share is near 1.
  std::vector<results::RunDetections> runs;
  for (int object = 0; object < 10; ++object) {
    for (int run = 0; run < 7; ++run) {
      const int delay = object == 0 && run < 2 ? 60 : 2 + 2 * ((object + run) % 6);
      runs.push_back({{"object-" + std::to_string(object), std::to_string(run), 0}, {detected(delay)}});
    }
  }
  const std::vector<results::DetectedWithin> curve = delay_table(runs, Touch::press).curve;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    ASSERT_TRUE(curve[i].share.has_interval()) << curve[i].ms;
    EXPECT_GE(*curve[i].share.low, *curve[i - 1].share.low) << curve[i].ms;
    EXPECT_GE(*curve[i].share.high, *curve[i - 1].share.high) << curve[i].ms;
    EXPECT_LE(*curve[i].share.low, curve[i].share.value);
    EXPECT_GE(*curve[i].share.high, curve[i].share.value);
  }
}

}  // namespace
}  // namespace tactile::evaluation
