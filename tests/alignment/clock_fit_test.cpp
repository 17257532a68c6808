#include "tactile/alignment/clock_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tactile/core/random.hpp"

namespace tactile::alignment {
namespace {

constexpr std::int64_t clock_start_us = 32'026'551'306;
constexpr std::int64_t true_offset_us = 1'746'661'631'692'315;

/// Anchors every `every_s` on a clock that drifts, each off by noise of its own standard deviation.
std::vector<ClockAnchor> anchors_of(int count, double every_s, double drift_ppm, double sigma_us, std::uint64_t seed = 1) {
  Random random(seed);
  const ClockRelation relation{.offset_us = true_offset_us, .drift_ppm = drift_ppm, .reference_us = clock_start_us};
  std::vector<ClockAnchor> anchors;
  for (int i = 0; i < count; ++i) {
    const std::int64_t clock = clock_start_us + std::llround(1e6 * every_s * i);
    anchors.push_back({.clock_us = clock,
                       .camera = relation.camera_from(clock) + microseconds{std::llround(sigma_us * random.normal())},
                       .sigma_us = sigma_us});
  }
  return anchors;
}

bool covers(const FittedClock& clock, double offset_us) {
  return static_cast<double>(clock.offset_low_us) <= offset_us && offset_us <= static_cast<double>(clock.offset_high_us);
}

TEST(FitClock, FindsOffsetAndDriftOfASession) {
  const auto anchors = anchors_of(12, 40, 57.0, 300);
  const ClockFit fit = fit_clock(anchors, clock_start_us, {.middle_us = clock_start_us + 200'000'000});
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_NEAR(fit.clock->relation.drift_ppm, 57.0, 3.0);
  EXPECT_NEAR(static_cast<double>(fit.clock->relation.offset_us - true_offset_us), 0.0, 600.0);
  EXPECT_EQ(fit.clock->relation.reference_us, clock_start_us);
  EXPECT_EQ(fit.clock->anchors, 12);
  EXPECT_NEAR(fit.clock->residual_us, 300, 200);
  EXPECT_EQ(fit.clock->method, "motions (12)");
}

TEST(FitClock, TakesADriftOfAHundredAndFiftyAndRefusesTwoHundredAndFifty) {
  const ClockFit good = fit_clock(anchors_of(8, 30, -150.0, 500), clock_start_us);
  ASSERT_TRUE(good.clock) << good.refused;
  EXPECT_NEAR(good.clock->relation.drift_ppm, -150.0, 10.0);
  const ClockFit bad = fit_clock(anchors_of(8, 30, 250.0, 20), clock_start_us);
  EXPECT_FALSE(bad.clock);
  EXPECT_NE(bad.refused.find("250"), std::string::npos) << bad.refused;
  EXPECT_NE(bad.refused.find("expected at most 200"), std::string::npos) << bad.refused;
}

TEST(FitClock, DoesNotEstimateADriftThatCannotBeMeasuredAndGivesTheReason) {
  const ClockFit few = fit_clock(anchors_of(3, 100, 0.0, 300), clock_start_us);
  ASSERT_TRUE(few.clock);
  EXPECT_EQ(few.clock->relation.drift_ppm, 0.0);
  EXPECT_EQ(few.clock->method, "motions (3); drift not estimated: 3 of 4 anchors");
  const ClockFit near = fit_clock(anchors_of(6, 5, 80.0, 300), clock_start_us);
  ASSERT_TRUE(near.clock);
  EXPECT_EQ(near.clock->relation.drift_ppm, 0.0);
  EXPECT_EQ(near.clock->method, "motions (6); drift not estimated: the anchors span 25 of 60 s");
  std::vector<ClockAnchor> vague = anchors_of(5, 20, 80.0, 1e5);
  const ClockFit open = fit_clock(vague, clock_start_us);
  ASSERT_TRUE(open.clock);
  EXPECT_EQ(open.clock->relation.drift_ppm, 0.0);
  EXPECT_EQ(open.clock->method, "motions (5); drift not estimated: the anchors do not determine it");
}

TEST(FitClock, AnUncertainWitnessDoesNotMakeADriftMeasurable) {
  std::vector<ClockAnchor> anchors = anchors_of(3, 40, 50.0, 300);
  anchors.push_back(anchors_of(1, 1, 0.0, 170'000, 2).front());
  anchors.back().clock_us += 200'000'000;
  anchors.back().camera += microseconds{200'000'000};
  const ClockFit fit = fit_clock(anchors, clock_start_us);
  ASSERT_TRUE(fit.clock);
  EXPECT_EQ(fit.clock->relation.drift_ppm, 0.0);
}

TEST(FitClock, LeavesOutAnchorsThatAreFarOff) {
  std::vector<ClockAnchor> anchors = anchors_of(10, 30, 20.0, 300);
  anchors[3].camera += 40ms;
  anchors[8].camera -= 800ms;
  const ClockFit fit = fit_clock(anchors, clock_start_us);
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_EQ(fit.clock->anchors, 8);
  EXPECT_FALSE(fit.used[3]);
  EXPECT_FALSE(fit.used[8]);
  EXPECT_NEAR(fit.clock->relation.drift_ppm, 20.0, 4.0);
}

TEST(FitClock, RefusesAnchorsThatContradictEachOther) {
  std::vector<ClockAnchor> anchors = anchors_of(4, 1, 0.0, 300);
  anchors[0].camera += 9s;
  anchors[1].camera -= 5s;
  anchors[2].camera += 1s;
  const ClockFit four = fit_clock(anchors, clock_start_us);
  EXPECT_FALSE(four.clock);
  EXPECT_NE(four.refused.find("the 4 anchors contradict each other"), std::string::npos) << four.refused;
  anchors.resize(2);
  EXPECT_FALSE(fit_clock(anchors, clock_start_us).clock);
  const ClockFit none = fit_clock({}, clock_start_us);
  EXPECT_FALSE(none.clock);
  EXPECT_EQ(none.refused, "nothing relates the two clocks");
}

TEST(FitClock, OfTwoThatContradictEachOtherUsesTheFarMoreCertain) {
  std::vector<ClockAnchor> anchors = anchors_of(2, 1, 0.0, 300);
  anchors[1].camera += 60ms;
  anchors[1].sigma_us = 3'000;
  const ClockFit fit = fit_clock(anchors, clock_start_us);
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_EQ(fit.clock->anchors, 1);
  EXPECT_NEAR(static_cast<double>(fit.clock->relation.offset_us - true_offset_us), 0.0, 1'000.0);
  EXPECT_LT(fit.clock->offset_high_us - fit.clock->offset_low_us, 2'000);
}

TEST(FitClock, CoversTheTruthIn95Percent) {
  int covered = 0, runs = 0;
  Random random(17);
  for (std::uint64_t seed = 1; seed <= 400; ++seed, ++runs) {
    const double drift = 60.0 * random.normal();
    const bool session = seed % 2 == 0;
    const auto anchors = session ? anchors_of(8, 45, drift, 800, seed) : anchors_of(1, 1, drift, 800, seed);
    const std::int64_t middle = clock_start_us + (session ? 100'000'000 : 20'000'000);
    const ClockFit fit = fit_clock(anchors, clock_start_us, {.middle_us = middle});
    ASSERT_TRUE(fit.clock);
    const ClockRelation truth{.offset_us = true_offset_us, .drift_ppm = drift, .reference_us = clock_start_us};
    const double error = static_cast<double>(between(truth.camera_from(middle), fit.clock->relation.camera_from(middle)).count());
    covered += covers(*fit.clock, static_cast<double>(fit.clock->relation.offset_us) - error) ? 1 : 0;
  }
  EXPECT_GE(covered, 0.91 * runs);
  EXPECT_LE(covered, 0.99 * runs) << "an interval that always holds says too little";
}

TEST(FitClock, MoreAnchorsDoNotReduceTheirCommonBias) {
  std::vector<ClockAnchor> anchors = anchors_of(50, 0.1, 0.0, 1'000, 3);
  for (ClockAnchor& anchor : anchors) anchor.bias_us = 5'000;
  const ClockFit fit = fit_clock(anchors, clock_start_us);
  ASSERT_TRUE(fit.clock);
  EXPECT_GT(fit.clock->offset_high_us - fit.clock->offset_low_us, 2 * 9'500);
}

TEST(FitClock, ADriftThatIsNotMeasuredWidensTheIntervalWithTheDistance) {
  const auto anchors = anchors_of(1, 1, 0.0, 100);
  const auto width = [&](std::int64_t away_us) {
    const ClockFit fit = fit_clock(anchors, clock_start_us, {.middle_us = clock_start_us + away_us});
    return fit.clock->offset_high_us - fit.clock->offset_low_us;
  };
  EXPECT_LT(width(0), 500);
  EXPECT_GT(width(300'000'000), 2 * 30'000) << "100 ppm over 300 s";
}

TEST(FitClock, HoldsAtTheEndsOfTime) {
  constexpr std::int64_t last = std::numeric_limits<std::int64_t>::max();
  std::vector<ClockAnchor> anchors;
  for (const std::int64_t before : {300'000'000, 200'000'000, 100'000'000, 50'000'000, 0})
    anchors.push_back({.clock_us = last - 1'000'000'000 - before, .camera = camera_time(last - before), .sigma_us = 100});
  const ClockFit fit = fit_clock(anchors, last - 1'300'000'000);
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_EQ(fit.clock->relation.offset_us, 1'000'000'000);
  EXPECT_NEAR(fit.clock->relation.drift_ppm, 0.0, 1e-6);

  const std::vector<ClockAnchor> apart{
      {.clock_us = last, .camera = camera_time(std::numeric_limits<std::int64_t>::min()), .sigma_us = 100}};
  const ClockFit refused = fit_clock(apart, last);
  EXPECT_FALSE(refused.clock);
  EXPECT_EQ(refused.refused, "the two clocks lie further apart than 64 bits of microseconds");
}

}  // namespace
}  // namespace tactile::alignment
