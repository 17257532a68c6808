#include "tactile/evaluation/accuracy_over_time.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/verdict_row.hpp"
#include "tactile/core/error.hpp"

namespace tactile::evaluation {
namespace {

using test::interval_ms;
using test::ticks_of;
using test::verdict_row;

constexpr results::OverTimeOptions small{.bin = 4ms, .longest = 16ms, .first = 6ms, .last = 4ms};

OverTimeCounts counts_in(std::string_view letters, std::vector<TouchInterval> intervals, Touch touch) {
  const auto verdicts = verdict_row(letters);
  return over_time_of(ticks_of(verdicts), verdicts, intervals, small)[static_cast<std::size_t>(touch)];
}

void expect_counts(const TickCount& counts, std::uint64_t ticks, std::uint64_t right, std::uint64_t intervals) {
  EXPECT_EQ(counts.ticks, ticks);
  EXPECT_EQ(counts.right, right);
  EXPECT_EQ(counts.intervals, intervals);
}

// Ticks lie at 0, 2, 4, ... ms, so tick i at 2 i ms.

TEST(OverTime, CountsTheTicksOfAnIntervalByTheirDistanceToBothEnds) {
  // The press holds 6, 8, 10, 12, 14 ms: 2, 4, 6, 8, 10 ms after its onset at 4 ms, and 8, 6, 4, 2, 0 ms before its end.
  const OverTimeCounts counts = counts_in("pp.pp.s.pp", {interval_ms(Touch::press, 4, 14)}, Touch::press);
  expect_counts(counts.first, 3, 2, 1);  // 6 and 8 ms right, 10 ms none
  expect_counts(counts.later, 2, 0, 1);  // 12 ms predicted slip, 14 ms none
  expect_counts(counts.last, 2, 0, 1);   // 12 and 14 ms: less than 4 ms before the end
  expect_counts(counts.since_onset[0], 2, 2, 1);
  expect_counts(counts.since_onset[1], 2, 0, 1);
  expect_counts(counts.since_onset[2], 1, 0, 1);
  EXPECT_EQ(counts.since_onset.size(), 3U);
  expect_counts(counts.before_end[0], 2, 0, 1);
  expect_counts(counts.before_end[1], 2, 1, 1);
  expect_counts(counts.before_end[2], 1, 1, 1);
}

TEST(OverTime, ComparesTheEndWithWhatIsAheadOfItInTheSameIntervalAlone) {
  // The first press, of 4 ms, is all end; the second holds 12, 14, 16, 18, 20 ms: 18 and 20 ms are its end.
  const OverTimeCounts counts =
      counts_in("..pp..ppp.p", {interval_ms(Touch::press, 3, 7), interval_ms(Touch::press, 11, 20)}, Touch::press);
  expect_counts(counts.last, 4, 3, 2);
  expect_counts(counts.last_of_long, 2, 1, 1);
  expect_counts(counts.before_last, 3, 3, 1);
}

TEST(OverTime, CountsWhatIsStillPredictedAfterAnInterval) {
  // After the end at 5 ms come 6, 8, 10 ms; the slip has 10 ms.
  const auto verdicts = verdict_row(".pppss..");
  results::OverTimeOptions options = small;
  options.after = 6ms;
  const std::vector<TouchInterval> press{interval_ms(Touch::press, 1, 5)}, slip{interval_ms(Touch::slip, 9, 12)};
  const auto counts = over_time_of(ticks_of(verdicts), verdicts, press, options, slip);
  expect_counts(counts[static_cast<std::size_t>(Touch::press)].after, 2, 0, 1);
  const auto alone = over_time_of(ticks_of(verdicts), verdicts, press, options);
  expect_counts(alone[static_cast<std::size_t>(Touch::press)].after, 3, 0, 1);
  const results::OverTime over_time = accuracy_over_time(std::vector<RunOverTime>{{{"fan"}, counts}}, options);
  EXPECT_EQ(over_time.press.all.still_predicted.value, 1.0);
}

TEST(OverTime, AddsIntervalsOfAClassAndKeepsClassesApart) {
  const std::vector<TouchInterval> intervals{interval_ms(Touch::press, 1, 4), interval_ms(Touch::press, 9, 12),
                                             interval_ms(Touch::slip, 13, 18)};
  expect_counts(counts_in(".pp..pp.s.", intervals, Touch::press).first, 4, 4, 2);
  expect_counts(counts_in(".pp..pp.s.", intervals, Touch::slip).first, 3, 1, 1);
}

TEST(OverTime, CountsTicksBeyondTheCurvesInTheSharesAlone) {
  const OverTimeCounts counts = counts_in(std::string(30, 's'), {interval_ms(Touch::slip, 0, 40)}, Touch::slip);
  std::uint64_t on_curve = 0;
  for (const TickCount& bin : counts.since_onset) on_curve += bin.ticks;
  EXPECT_EQ(on_curve, 8U);
  EXPECT_EQ(counts.first.ticks + counts.later.ticks, 20U);
}

TEST(OverTime, NeedsOneVerdictForEachTick) {
  const auto verdicts = verdict_row("...");
  TickRange ticks = ticks_of(verdicts);
  ticks.count = 2;
  EXPECT_THROW(over_time_of(ticks, verdicts, {}), Error);
}

TEST(AccuracyOverTime, IsTheMeanOverObjectsAndTheDifferenceIsPaired) {
  const auto run = [](std::string object, std::string_view letters) {
    const auto verdicts = verdict_row(letters);
    const std::vector<TouchInterval> press{interval_ms(Touch::press, 1, 18)};
    return RunOverTime{{std::move(object)}, over_time_of(ticks_of(verdicts), verdicts, press, small)};
  };
  // Ticks 1 to 9 are in; of the fan's first three all are right and of its last two none, of the box's all.
  const std::vector<RunOverTime> runs{run("fan", ".ppppppp.."), run("box", ".ppppppppp")};
  const results::OverTime over_time = accuracy_over_time(runs, small);
  EXPECT_DOUBLE_EQ(over_time.press.all.first.value, 1.0);
  EXPECT_DOUBLE_EQ(over_time.press.all.last.value, 0.5);
  EXPECT_DOUBLE_EQ(over_time.press.all.last_minus_before.value, -0.5);
  EXPECT_DOUBLE_EQ(over_time.press.objects.at("fan").last_minus_before.value, -1.0);
  EXPECT_EQ(over_time.press.all.intervals, 2U);
  EXPECT_EQ(over_time.press.all.short_ones, 0U);
  EXPECT_EQ(over_time.press.all.first.n, 2U);
  EXPECT_TRUE(std::isnan(over_time.slip.all.first.value));
  EXPECT_TRUE(over_time.slip.since_onset.empty());
  EXPECT_EQ(over_time.both.all.first.value, over_time.press.all.first.value);
  ASSERT_EQ(over_time.press.before_end.size(), 4U);
  EXPECT_DOUBLE_EQ(over_time.press.before_end[0].accuracy.value, 0.5);
  EXPECT_EQ(over_time.press.before_end[0].ticks, 4U);
  EXPECT_EQ(over_time.press.before_end[0].intervals, 2U);
  const nlohmann::json json = over_time;
  EXPECT_EQ(json.at("press").at("since_onset").at(1).at("from_ms"), 4.0);
  EXPECT_EQ(json.at("last_ms"), 4.0);
}

}  // namespace
}  // namespace tactile::evaluation
