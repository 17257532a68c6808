#include "tactile/experiments/trade/trade_figures.hpp"

#include <gtest/gtest.h>

namespace tactile::trade {
namespace {

JudgedRun run_with_a_press() {
  JudgedRun run{.run = "fan/03", .object = "fan", .samples = {}, .truth = {}, .guard = 0ms};
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
  const TradedRun outcome = outcome_of(run, predicted, predicted.verdicts);
  EXPECT_EQ(outcome.confusion.counts[0][0], 1U);
  EXPECT_EQ(outcome.confusion.counts[1][1], 2U);
  EXPECT_EQ(outcome.confusion.counts[1][2], 1U);
}

TEST(OutcomeOf, ADelayIsCountedFromTheOnsetItself) {
  const JudgedRun run = run_with_a_press();
  const results::FullRun predicted =
      predicted_every(10ms, camera_time(10'000), {Touch::none, Touch::none, Touch::none, Touch::press, Touch::press});
  const TradedRun outcome = outcome_of(run, predicted, predicted.verdicts);
  EXPECT_EQ(outcome.intervals, 1U);
  EXPECT_EQ(outcome.delays_us, std::vector<double>{40'000 - 21'000});
  EXPECT_EQ(outcome.misses + outcome.early, 0U);
  const results::FullRun silent = predicted_every(10ms, camera_time(10'000), std::vector<Touch>(6, Touch::none));
  EXPECT_EQ(outcome_of(run, silent, silent.verdicts).misses, 1U);
}

TradedRun outcome(const std::string& object, std::uint64_t right, std::uint64_t wrong, std::vector<double> delays,
                  std::vector<double> tick_us) {
  TradedRun made;
  made.object = object;
  made.confusion.counts[1][1] = right;
  made.confusion.counts[1][0] = wrong;
  made.intervals = delays.size() + 1;
  made.misses = 1;
  made.delays_us = std::move(delays);
  made.tick_us = made.open_tick_us = std::move(tick_us);
  made.alarms.alarms = 2;
  made.alarms.none_time = std::chrono::seconds(60);
  return made;
}

TEST(ResultOf, IsWhatOneWorksOutByHand) {
  const std::vector<TradedRun> runs{outcome("a", 3, 1, {1000, 3000}, {10, 20, 30}), outcome("b", 4, 0, {5000}, {40, 50}),
                                    outcome("c", 2, 2, {7000}, {60})};
  const TradeResult result = result_of(runs);
  EXPECT_DOUBLE_EQ(result.figures.accuracy.value, (0.75 + 1 + 0.5) / 3);
  EXPECT_DOUBLE_EQ(result.figures.us_p50.value, 35);
  EXPECT_DOUBLE_EQ(result.figures.us_p99.value, 50 + 0.95 * 10);
  EXPECT_DOUBLE_EQ(result.figures.delay_us.value, 4000 + 35) << "computing included";
  EXPECT_DOUBLE_EQ(result.delay_p95_us.value, 5000 + 0.85 * 2000 + 35);
  EXPECT_DOUBLE_EQ(result.missed.value, 3.0 / 7);
  EXPECT_DOUBLE_EQ(result.figures.false_alarms_per_min.value, 2);
  EXPECT_EQ(result.intervals, 7U);
  EXPECT_EQ(result.misses, 3U);
  ASSERT_TRUE(result.figures.accuracy.low && result.figures.accuracy.high);
  EXPECT_LE(*result.figures.accuracy.low, result.figures.accuracy.value);
  EXPECT_GE(*result.figures.accuracy.high, result.figures.accuracy.value);
}

TEST(ResultOf, TakesTheTimeOfTicksThatNoGateClosesIntoDelays) {
  std::vector<TradedRun> runs{outcome("a", 3, 1, {1000}, {1, 1, 1, 150})};
  runs[0].open_tick_us = {150};
  EXPECT_DOUBLE_EQ(result_of(runs).figures.us_p50.value, 1);
  EXPECT_DOUBLE_EQ(result_of(runs).figures.delay_us.value, 1150);
  runs[0].open_tick_us.clear();
  EXPECT_DOUBLE_EQ(result_of(runs).figures.delay_us.value, 1001);
}

TEST(ResultOf, DoesNotTakeNoAlarmForNone) {
  std::vector<TradedRun> runs;
  for (const char* object : {"a", "b", "c"}) {
    runs.push_back(outcome(object, 3, 1, {1000}, {10}));
    runs.back().alarms.alarms = 0;
    runs.back().alarms.none_time = std::chrono::seconds(20);
  }
  const results::Figure in_a_minute = result_of(runs).figures.false_alarms_per_min;
  EXPECT_EQ(in_a_minute.value, 0);
  ASSERT_TRUE(in_a_minute.low && in_a_minute.high);
  EXPECT_EQ(*in_a_minute.low, 0);
  EXPECT_NEAR(*in_a_minute.high, 3.6889, 1e-4) << "none met in a minute";
  // Another seed on the same runs is no other minute.
  for (TradedRun& run : runs) run += TradedRun(run);
  EXPECT_NEAR(*result_of(runs).figures.false_alarms_per_min.high, 3.6889, 1e-4);
  // Many that differ between runs: the draws say more.
  for (std::size_t i = 0; i < runs.size(); ++i) runs[i].alarms.alarms = 1000 * i;
  EXPECT_GT(*result_of(runs).figures.false_alarms_per_min.high, 1900);
}

TEST(DifferenceOf, IsPairedOverRuns) {
  // Ten times as much between objects as between settings: only a paired interval tells them apart.
  std::vector<TradedRun> a, b;
  for (const auto& [object, right] : {std::pair("a", 50U), std::pair("b", 70U), std::pair("c", 90U), std::pair("d", 60U)}) {
    a.push_back(outcome(object, right, 100 - right, {1000}, {10}));
    b.push_back(outcome(object, right + 2, 98 - right, {3000}, {15}));
  }
  const TradeDifference difference = difference_of(a, b);
  EXPECT_NEAR(difference.accuracy.value, 0.02, 1e-12);
  ASSERT_TRUE(difference.accuracy.low);
  EXPECT_NEAR(*difference.accuracy.low, 0.02, 1e-12);
  EXPECT_DOUBLE_EQ(difference.delay_us.value, 2005);
  EXPECT_DOUBLE_EQ(difference.us_p99.value, 5);
  b.pop_back();
  EXPECT_ANY_THROW(difference_of(a, b));
}

TEST(TradedRun, SeedsAreCountedTogether) {
  TradedRun sum = outcome("a", 3, 1, {1000}, {10});
  sum += outcome("a", 1, 3, {2000, 4000}, {99});
  EXPECT_EQ(sum.confusion.samples(), 8U);
  EXPECT_EQ(sum.delays_us.size(), 3U);
  EXPECT_EQ(sum.intervals, 5U);
  EXPECT_EQ(sum.alarms.alarms, 4U);
  EXPECT_EQ(sum.seeds, 2U);
  EXPECT_EQ(sum.tick_us, std::vector<double>{10}) << "time is that of the first";
}

}  // namespace
}  // namespace tactile::trade
