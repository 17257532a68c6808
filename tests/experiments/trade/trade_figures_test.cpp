#include "tactile/experiments/trade/trade_figures.hpp"

#include <gtest/gtest.h>

namespace tactile::trade {
namespace {

JudgedRun run_with_a_press() {
  JudgedRun run{.folder = {{}, "fan", "03"}, .events_sha256 = {}, .samples = {}, .truth = {}};
  run.truth.labels = {{{Touch::press, camera_time(21'000), camera_time(61'000)}, true}};
  return run;
}

results::FullRun predicted_every(microseconds tick, CameraTime first, const std::vector<Touch>& verdicts) {
  results::FullRun run{.run = "fan/03",
                       .ticks = {.first = first, .count = static_cast<std::int64_t>(verdicts.size()), .tick = tick},
                       .verdicts = verdicts};
  run.events.assign(verdicts.size(), 100);
  return run;
}

TEST(OutcomeOf, ASampleTakesTheVerdictOfTheLastTickUpToIt) {
  JudgedRun run = run_with_a_press();
  run.samples = {{0, camera_time(8'000), Touch::none},     // before the first tick: none
                 {0, camera_time(30'000), Touch::press},   // at a tick
                 {0, camera_time(38'000), Touch::press},   // 8 ms after it
                 {0, camera_time(42'000), Touch::press}};  // after the last one
  const results::FullRun predicted = predicted_every(10ms, camera_time(20'000), {Touch::slip, Touch::press, Touch::slip});
  const results::Cell outcome = cell_of(run, predicted, predicted.verdicts);
  EXPECT_EQ(outcome.samples.counts[0][0], 1U);
  EXPECT_EQ(outcome.samples.counts[1][1], 2U);
  EXPECT_EQ(outcome.samples.counts[1][2], 1U);
}

TEST(OutcomeOf, ADelayIsCountedFromTheOnsetItself) {
  const JudgedRun run = run_with_a_press();
  const results::FullRun predicted =
      predicted_every(10ms, camera_time(10'000), {Touch::none, Touch::none, Touch::none, Touch::press, Touch::press});
  const results::Cell outcome = cell_of(run, predicted, predicted.verdicts);
  EXPECT_EQ(outcome.touches, (std::vector<results::TouchOutcome>{{Touch::press, results::DetectionOutcome::detected, 40 - 21}}));
  const results::FullRun silent = predicted_every(10ms, camera_time(10'000), std::vector<Touch>(6, Touch::none));
  const results::Cell missed = cell_of(run, silent, silent.verdicts);
  EXPECT_EQ(missed.touches, (std::vector<results::TouchOutcome>{{Touch::press, results::DetectionOutcome::missed, 61 - 21}}))
      << "its limit is the end";
}

TEST(OutcomeOf, AMissCountsWithHalfASecondAtMost) {
  JudgedRun run = run_with_a_press();
  run.truth.labels.front().interval.end = camera_time(2'000'000);
  const results::FullRun silent = predicted_every(10ms, camera_time(10'000), std::vector<Touch>(60, Touch::none));
  EXPECT_EQ(cell_of(run, silent, silent.verdicts).touches,
            (std::vector<results::TouchOutcome>{{Touch::press, results::DetectionOutcome::missed, 500}}));
}

/// Each detected delay, and one miss at 9 ms.
results::Cell outcome(const std::string& object, std::uint64_t right, std::uint64_t wrong, const std::vector<double>& delays,
                      std::size_t training = 0) {
  results::Cell made;
  made.object = object;
  made.run = "03";
  made.training = training;
  made.samples.counts[1][1] = right;
  made.samples.counts[1][0] = wrong;
  for (const double us : delays) made.touches.push_back({Touch::press, results::DetectionOutcome::detected, us / 1000});
  made.touches.push_back({Touch::press, results::DetectionOutcome::missed, 9});
  made.alarms["quiet"] = 2;
  made.outside_s = 60;
  return made;
}

TimedRun timed(const std::string& object, std::vector<float> tick_us) {
  TimedRun made;
  made.object = object;
  made.run = "03";
  made.tick_us = std::move(tick_us);
  return made;
}

TEST(ResultOf, IsWhatOneWorksOutByHand) {
  const std::vector<results::Cell> runs{outcome("a", 3, 1, {1000, 3000}), outcome("b", 4, 0, {5000}), outcome("c", 2, 2, {7000})};
  const std::vector<TimedRun> times{timed("a", {10, 20, 30}), timed("b", {40, 50}), timed("c", {60})};
  const results::TradeResult result = result_of(runs, times);
  EXPECT_DOUBLE_EQ(result.accuracy.value, (0.75 + 1 + 0.5) / 3);
  EXPECT_DOUBLE_EQ(result.us_p50.value, 30);
  EXPECT_DOUBLE_EQ(result.us_p99.value, 60);
  EXPECT_DOUBLE_EQ(result.us_p999.value, 60);
  EXPECT_EQ(result.ticks, 6U);
  // 1, 3, 5, 7, 9, 9, 9 ms, the last three missed; computing included.
  EXPECT_DOUBLE_EQ(result.whole_runs.median_ms.ms.value, 8 + 0.03) << "the fourth tick of 2 ms";
  EXPECT_FALSE(result.whole_runs.median_ms.is_lower_bound);
  EXPECT_DOUBLE_EQ(result.whole_runs.p90_ms.ms.value, 9 + 0.03);
  EXPECT_TRUE(result.whole_runs.p90_ms.is_lower_bound);
  EXPECT_DOUBLE_EQ(result.whole_runs.missed.value, 3.0 / 7);
  EXPECT_DOUBLE_EQ(result.whole_runs.alarms_per_min.value, 2);
  EXPECT_EQ(result.whole_runs.alarms, 6U);
  EXPECT_EQ(result.whole_runs.touches, 7U);
  EXPECT_EQ(result.whole_runs.misses, 3U);
  ASSERT_TRUE(result.accuracy.low && result.accuracy.high);
  EXPECT_LE(*result.accuracy.low, result.accuracy.value);
  EXPECT_GE(*result.accuracy.high, result.accuracy.value);
}

TEST(ResultOf, DrawsTrainings) {
  // Objects are equal, trainings are not: only drawn trainings give an interval.
  std::vector<results::Cell> runs;
  for (const char* object : {"a", "b", "c"}) {
    runs.push_back(outcome(object, 90, 10, {1000}, 0));
    runs.push_back(outcome(object, 80, 20, {1000}, 1));
    runs.push_back(outcome(object, 70, 30, {1000}, 2));
  }
  const results::Figure accuracy = result_of(runs, {}).accuracy;
  EXPECT_DOUBLE_EQ(accuracy.value, 0.8);
  EXPECT_EQ(accuracy.trainings, 3U);
  ASSERT_TRUE(accuracy.has_interval());
  // The standard error is 0.1 / sqrt(3), and t of two degrees of freedom 6.2: as of 4.8 trials. From SciPy.
  EXPECT_NEAR(*accuracy.low, 0.2727486076427136, 1e-9);
  EXPECT_NEAR(*accuracy.high, 0.995625859644821, 1e-9);
  std::erase_if(runs, [](const results::Cell& run) { return run.training == 2; });
  EXPECT_FALSE(result_of(runs, {}).accuracy.has_interval()) << "two trainings";
}

TEST(ResultOf, TakesIntervalsOverRunsOfFewerThanThreeObjects) {
  // Four runs of each of two objects, each judged by one training.
  std::vector<results::Cell> runs;
  std::vector<TimedRun> times;
  for (const char* object : {"a", "b"}) {
    for (std::size_t run = 0; run < 4; ++run) {
      runs.push_back(outcome(object, 80 + run, 20 - run, {1000}, run));
      times.push_back(timed(object, {10.0F + static_cast<float>(run)}));
      runs.back().run = times.back().run = std::to_string(run);
    }
  }
  const results::TradeResult figures = result_of(runs, times);
  EXPECT_DOUBLE_EQ(figures.accuracy.value, 0.815);
  ASSERT_TRUE(figures.accuracy.has_interval());
  EXPECT_LT(*figures.accuracy.low, 0.81);
  EXPECT_GT(*figures.accuracy.high, 0.82);
  EXPECT_EQ(figures.accuracy.n, 8U) << "runs";
  EXPECT_TRUE(figures.us_p99.has_interval());
  // Two runs of one are too few.
  runs.resize(6), times.resize(6);
  EXPECT_FALSE(result_of(runs, times).accuracy.has_interval());
}

TEST(ResultOf, HasTheShareOfInterruptedTicks) {
  std::vector<TimedRun> times{timed("a", {10, 20, 30}), timed("b", {40})};
  EXPECT_EQ(result_of({}, times).interrupted, 0);
  times[0].interrupted = 1;
  EXPECT_DOUBLE_EQ(result_of({}, times).interrupted, 0.25);
  const std::vector<TickTime> ticks{{.counting = 1}, {.counting = 1, .interruptions = 2}};
  EXPECT_EQ(timed_run({}, ticks).interrupted, 1U);
}

TEST(ResultOf, HasAnIntervalAboveZeroWithoutAnAlarm) {
  std::vector<results::Cell> runs;
  for (const char* object : {"a", "b", "c"}) {
    runs.push_back(outcome(object, 3, 1, {1000}));
    runs.back().alarms.clear();
    runs.back().outside_s = 20;
  }
  const results::Figure in_a_minute = result_of(runs, {}).whole_runs.alarms_per_min;
  EXPECT_EQ(in_a_minute.value, 0);
  ASSERT_TRUE(in_a_minute.low && in_a_minute.high);
  EXPECT_EQ(*in_a_minute.low, 0);
  EXPECT_NEAR(*in_a_minute.high, 3.6889, 1e-4) << "none met in a minute";
  // Other trainings on the same runs see no other minute.
  std::vector<results::Cell> thrice;
  for (results::Cell run : runs) {
    for (run.training = 0; run.training < 3; ++run.training) thrice.push_back(run);
  }
  EXPECT_NEAR(*result_of(thrice, {}).whole_runs.alarms_per_min.high, 3.6889, 1e-4);
  // Many that differ between runs: the draws say more.
  for (std::size_t i = 0; i < runs.size(); ++i) runs[i].alarms["quiet"] = 1000 * i;
  EXPECT_GT(*result_of(runs, {}).whole_runs.alarms_per_min.high, 1900);
}

}  // namespace
}  // namespace tactile::trade
