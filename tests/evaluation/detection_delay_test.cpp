#include "tactile/evaluation/detection_delay.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/verdict_row.hpp"
#include "tactile/core/error.hpp"

namespace tactile::evaluation {
namespace {

using test::interval_ms;
using test::ticks_of;
using test::verdict_row;

results::Detection detection_in(std::string_view letters, TouchInterval interval, DelayOptions options = {}) {
  const auto verdicts = verdict_row(letters);
  const TouchInterval intervals[] = {interval};
  return detections_of(ticks_of(verdicts), verdicts, intervals, options).front();
}

// Ticks lie at 0, 2, 4, ... ms, so tick i at 2 i ms.

TEST(DetectionDelay, OfAVerdictRightAtTheFirstTickIsOneTick) {
  // Onset at 5 ms: k0 is tick 3 at 6 ms.
  const results::Detection detection = detection_in("...pp", interval_ms(Touch::press, 5, 100));
  EXPECT_EQ(detection.outcome, results::DetectionOutcome::detected);
  EXPECT_EQ(detection.delay, 2ms);
  EXPECT_EQ(detection.first_right, camera_time(6000));
  EXPECT_FALSE(detection.leading_episode.has_value());
}

TEST(DetectionDelay, CountsTicksFromTheFirstAfterTheOnset) {
  const results::Detection detection = detection_in("......s", interval_ms(Touch::slip, 5, 100));
  EXPECT_EQ(detection.outcome, results::DetectionOutcome::detected);
  EXPECT_EQ(detection.delay, 8ms);  // k0 = 3, k = 6
}

TEST(DetectionDelay, BeginsAfterATickThatLiesExactlyOnTheOnset) {
  // Onset at 6 ms: tick 3 is not after it, k0 is tick 4; the press predicted at tick 3 alone led to nothing.
  EXPECT_EQ(detection_in("....p", interval_ms(Touch::press, 6, 100)).delay, 2ms);
  EXPECT_EQ(detection_in("...p.p", interval_ms(Touch::press, 6, 100)).delay, 4ms);
}

TEST(DetectionDelay, TakesOnlyTheRightClass) {
  EXPECT_EQ(detection_in("...ssp", interval_ms(Touch::press, 5, 100)).delay, 6ms);
  EXPECT_EQ(detection_in("...ss", interval_ms(Touch::press, 5, 100)).outcome, results::DetectionOutcome::missed);
}

TEST(DetectionDelay, OfAnEpisodeThatBeginsTenMillisecondsAheadIsOneTick) {
  // Onset at 21 ms: k0 is tick 11 at 22 ms; the episode begins at tick 6, 10 ms before k0.
  const results::Detection detection = detection_in("......pppppp", interval_ms(Touch::press, 21, 100));
  EXPECT_EQ(detection.outcome, results::DetectionOutcome::detected);
  EXPECT_EQ(detection.delay, 2ms);
  EXPECT_EQ(detection.leading_episode, 6);
}

TEST(DetectionDelay, IsEarlyWhereTheEpisodeBeginsFurtherAhead) {
  const results::Detection detection = detection_in(".....ppppppp", interval_ms(Touch::press, 21, 100));
  EXPECT_EQ(detection.outcome, results::DetectionOutcome::early);
  EXPECT_EQ(detection.leading_episode, 5);
}

TEST(DetectionDelay, OfAnEpisodeThatEndsBeforeTheFirstTickIsCountedAsUsual) {
  // Press predicted until tick 10, not at k0 = 11; predicted again at tick 12.
  const results::Detection detection = detection_in("ppppppppppp.p", interval_ms(Touch::press, 21, 100));
  EXPECT_EQ(detection.outcome, results::DetectionOutcome::detected);
  EXPECT_EQ(detection.delay, 4ms);
  EXPECT_FALSE(detection.leading_episode.has_value());
}

TEST(DetectionDelay, AnotherClassAheadOfTheOnsetIsNoHeadStart) {
  const results::Detection detection = detection_in("sssssssssssp", interval_ms(Touch::press, 21, 100));
  EXPECT_EQ(detection.outcome, results::DetectionOutcome::detected);
  EXPECT_EQ(detection.delay, 2ms);
}

TEST(DetectionDelay, IsAMissWithoutARightVerdict) {
  const results::Detection detection = detection_in("............", interval_ms(Touch::press, 5, 12));
  EXPECT_EQ(detection.outcome, results::DetectionOutcome::missed);
}

TEST(DetectionDelay, StillCountsATickExactlyAtTheEnd) {
  // Ends at 12 ms, the time of tick 6; tick 7 is after it.
  EXPECT_EQ(detection_in("......p", interval_ms(Touch::press, 5, 12)).delay, 8ms);
  EXPECT_EQ(detection_in(".......p", interval_ms(Touch::press, 5, 12)).outcome, results::DetectionOutcome::missed);
}

TEST(DetectionDelay, StopsHalfASecondAfterTheOnset) {
  // Onset at 4 ms: the last tick that counts is at 504 ms, index 252; k0 is index 3.
  std::string letters(300, '.');
  letters[252] = 's';
  EXPECT_EQ(detection_in(letters, interval_ms(Touch::slip, 4, 590)).delay, 500ms);
  letters[252] = '.';
  letters[253] = 's';
  EXPECT_EQ(detection_in(letters, interval_ms(Touch::slip, 4, 590)).outcome, results::DetectionOutcome::missed);
}

TEST(DetectionDelay, OfAnIntervalShorterThanATickIsAMiss) {
  const auto verdicts = verdict_row("....pp");
  const TouchInterval between_ticks{Touch::press, camera_time(6100), camera_time(7900)};
  EXPECT_EQ(detections_of(ticks_of(verdicts), verdicts, {&between_ticks, 1}).front().outcome, results::DetectionOutcome::missed);
}

TEST(DetectionDelay, CountsFromTheOnsetAlsoWhereTheFirstTicksAreMissing) {
  // Full ticks begin at 40 ms only; onset at 31 ms, so k0 would have been at 32 ms and the first verdict is 4 ticks after it.
  const auto verdicts = verdict_row("pp");
  const TouchInterval interval = interval_ms(Touch::press, 31, 100);
  const results::Detection detection = detections_of(ticks_of(verdicts, 40), verdicts, {&interval, 1}).front();
  EXPECT_EQ(detection.outcome, results::DetectionOutcome::detected);
  EXPECT_EQ(detection.delay, 10ms);
}

TEST(DetectionDelay, OfAnIntervalAfterTheLastTickIsAMiss) {
  EXPECT_EQ(detection_in("pppp", interval_ms(Touch::press, 50, 100)).outcome, results::DetectionOutcome::missed);
}

TEST(DetectionDelay, HoldsForNegativeTimes) {
  const auto verdicts = verdict_row("...pp");
  const TouchInterval interval = interval_ms(Touch::press, -95, 0);  // ticks from -100 ms on: k0 is tick 3 at -94 ms
  EXPECT_EQ(detections_of(ticks_of(verdicts, -100), verdicts, {&interval, 1}).front().delay, 2ms);
}

TEST(DetectionDelay, HoldsAtBothEndsOfTheClock) {
  constexpr std::int64_t lowest = std::numeric_limits<std::int64_t>::min(), highest = std::numeric_limits<std::int64_t>::max();
  const auto verdicts = verdict_row("...pp");
  for (const std::int64_t first : {lowest - lowest % 2'000 + 2'000, highest - highest % 2'000 - 8'000}) {
    const TickRange ticks{camera_time(first), 5, 2ms};
    const TouchInterval interval{Touch::press, camera_time(first + 4'500), after(camera_time(first), 100ms)};
    const results::Detection detection = detections_of(ticks, verdicts, {&interval, 1}).front();
    EXPECT_EQ(detection.outcome, results::DetectionOutcome::detected) << first;
    EXPECT_EQ(detection.delay, 2ms) << first;
    EXPECT_EQ(detection.first_right, camera_time(first + 6'000)) << first;
    const TouchInterval far{Touch::press, camera_time(first < 0 ? highest - 500 : lowest),
                            camera_time(first < 0 ? highest : lowest + 500)};
    EXPECT_EQ(detections_of(ticks, verdicts, {&far, 1}).front().outcome, results::DetectionOutcome::missed) << "at the other end";
  }
}

TEST(DetectionDelay, NeedsOneVerdictForEachTick) {
  const auto verdicts = verdict_row("...");
  TickRange ticks = ticks_of(verdicts);
  ticks.count = 4;
  EXPECT_THROW(detections_of(ticks, verdicts, {}), Error);
}

}  // namespace
}  // namespace tactile::evaluation
