#include "tactile/labels/touch_end.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "labels/lit_rate_of.hpp"

namespace tactile::labels {
namespace {

constexpr double begin_us = 1'000'000, touch_onset_us = 200'000, still_us = 450'000;

CameraTime time_of(double us) { return camera_time(std::llround(begin_us + us)); }

alignment::UncertainTime exactly(double us) { return {time_of(us), time_of(us), time_of(us)}; }

/// A press that slows down as (1 - t)^power, with creeping after it.
double press_rate(double t_us, double power, double peak, double creeping) {
  if (t_us < touch_onset_us) return 0.2;
  if (t_us >= still_us) return 0.2 + creeping;
  return 0.2 + peak * std::pow((still_us - t_us) / (still_us - touch_onset_us), power);
}

struct Ends {
  std::vector<double> errors_ms, widths_ms;  ///< ascending
  int covered = 0, doubted = 0;
};

Ends press_ends(double power, double peak, double creeping, std::uint64_t seeds) {
  const double end_us = still_us - (still_us - touch_onset_us) * std::pow(0.01, 1.0 / power);
  Ends ends;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const LitRate lit = test::lit_rate_of(
        5'000, [&](double t_us) { return press_rate(t_us, power, peak, creeping); }, seed, 1'000, 2'260, 0.2);
    const FoundTime found = press_end(lit, exactly(touch_onset_us));
    EXPECT_LE(found.time.low, found.time.at);
    EXPECT_LE(found.time.at, found.time.high);
    ends.errors_ms.push_back(1e-3 * std::abs(static_cast<double>(between(time_of(end_us), found.time.at).count())));
    ends.widths_ms.push_back(1e-3 * static_cast<double>(between(found.time.low, found.time.high).count()));
    ends.covered += found.time.low <= time_of(end_us) && time_of(end_us) <= found.time.high ? 1 : 0;
    ends.doubted += found.doubt.empty() ? 0 : 1;
  }
  std::sort(ends.errors_ms.begin(), ends.errors_ms.end());
  std::sort(ends.widths_ms.begin(), ends.widths_ms.end());
  return ends;
}

TEST(PressEnd, IsFoundHoweverThePressSlowsDown) {
  for (const double power : {0.6, 1.0, 1.4}) {
    const Ends ends = press_ends(power, 40.0, 0.1, 60);
    EXPECT_LE(ends.errors_ms[30], 2.0) << power;
    EXPECT_LE(ends.errors_ms[56], 5.0) << power;
    EXPECT_GE(ends.covered, 54) << power;
    EXPECT_LE(ends.widths_ms[30], 16.0) << power;
    EXPECT_LE(ends.doubted, 3) << power;
  }
}

TEST(PressEnd, HasAWiderIntervalWhereFewEventsShowIt) {
  const Ends many = press_ends(1.0, 100.0, 0.1, 20), few = press_ends(1.0, 3.0, 0.02, 20);
  EXPECT_LT(many.widths_ms[10], few.widths_ms[10]);
  EXPECT_GE(few.covered, 17);
}

TEST(TouchEnd, IsAfterTheOnsetHoweverLateThatIsFound) {
  const LitRate lit = test::lit_rate_of(
      5'000, [](double t_us) { return press_rate(t_us, 1.0, 40.0, 0.1); }, 1, 1'000, 2'260, 0.2);
  for (const double late_us : {touch_onset_us, still_us, still_us + 60'000, 998'000.0, 999'600.0}) {  // the recording lasts 1 s
    for (const FoundTime& end : {press_end(lit, exactly(late_us)), slip_end(lit, exactly(late_us))}) {
      EXPECT_GE(end.time.at, after(time_of(late_us), lit.rate.bin)) << late_us;
      EXPECT_GE(end.time.high, end.time.at) << late_us;
    }
  }
}

TEST(PressEnd, IsDoubtedWhereTheTipsCreepOnAtAPercentOfThePeak) {
  const LitRate lit = test::lit_rate_of(
      5'000, [](double t_us) { return press_rate(t_us, 1.0, 100.0, 1.5); }, 1, 1'000, 2'600, 0.2);
  EXPECT_FALSE(press_end(lit, exactly(touch_onset_us)).doubt.empty());
}

TEST(PressEnd, IsDoubtedWhereItsIntervalIsTooWide) {
  const LitRate lit = test::lit_rate_of(
      5'000, [](double t_us) { return press_rate(t_us, 1.0, 40.0, 0.1); }, 1, 1'000, 2'260, 0.2);
  EXPECT_EQ(press_end(lit, exactly(touch_onset_us)).doubt.words, "");
  // It is 6 ms wide at least: creep shifts an end by 3 ms either way.
  const std::string words = press_end(lit, exactly(touch_onset_us), {.too_wide_ms = 5.0}).doubt.words;
  EXPECT_EQ(words.find("its end is only known to within "), 0U) << words;
}

TEST(PressEnd, IsThatOfTheMotionBeforeTheStillHold) {
  // 60 ms after the still hold some tips spring back: more events for an instant than the press ever has.
  const LitRate lit = test::lit_rate_of(
      5'000,
      [](double t_us) {
        return press_rate(t_us, 1.0, 20.0, 0.1) + (t_us > still_us + 60'000 && t_us < still_us + 75'000 ? 60.0 : 0.0);
      },
      2, 1'000, 2'640, 0.2);
  EXPECT_NEAR(1e-3 * static_cast<double>(between(time_of(still_us), press_end(lit, exactly(touch_onset_us)).time.at).count()),
              -2.5, 4.0);
}

/// A slip whose last tips let go at `still_us` and ring, e-fold `decay_us`.
LitRate slip_rate(double decay_us, double ringing, std::uint64_t seed) {
  return test::lit_rate_of(
      6'000,
      [=](double t_us) {
        if (t_us < touch_onset_us) return 0.2;
        if (t_us < still_us) return 40.0;
        return 0.2 + 100.0 * std::exp(-(t_us - still_us) / decay_us) + ringing * std::exp(-(t_us - still_us) / 80'000.0);
      },
      seed, 1'000, 2'400, 0.2);
}

TEST(SlipEnd, HoldsTheTimeInWhichTheRingingFadesToAPercent) {
  for (const double decay_us : {4'000.0, 8'000.0, 12'000.0}) {
    const double end_us = still_us + decay_us * std::log(100.0);
    int covered = 0;
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
      const alignment::UncertainTime end = slip_end(slip_rate(decay_us, 0.0, seed), exactly(touch_onset_us)).time;
      EXPECT_LE(end.low, end.at);
      EXPECT_LE(end.at, end.high);
      covered += end.low <= time_of(end_us) && time_of(end_us) <= end.high ? 1 : 0;
    }
    EXPECT_GE(covered, 27) << decay_us;
  }
}

TEST(SlipEnd, LeavesOpenWhetherALongFaintTailBelongsToIt) {
  const alignment::UncertainTime brief = slip_end(slip_rate(4'000.0, 0.0, 1), exactly(touch_onset_us)).time;
  const alignment::UncertainTime tailed = slip_end(slip_rate(4'000.0, 6.0, 1), exactly(touch_onset_us)).time;
  EXPECT_GT(between(tailed.low, tailed.high), between(brief.low, brief.high));
  EXPECT_LE(tailed.low, time_of(still_us + 30'000));
}

TEST(SlipEnd, IsNotBeforeTheArmsStopNorLongAfterIt) {
  const LitRate brief = slip_rate(4'000.0, 0.0, 1), rings = slip_rate(4'000.0, 60.0, 1);
  const auto stop = [](double t_us) {
    return alignment::UncertainTime{time_of(t_us), time_of(t_us - 1'000), time_of(t_us + 1'000)};
  };
  const alignment::UncertainTime unseen = slip_end(brief, exactly(touch_onset_us), {}, stop(still_us + 60'000)).time;
  EXPECT_GE(unseen.at, time_of(still_us + 60'000));
  EXPECT_LT(unseen.low, time_of(still_us + 60'000));
  EXPECT_GT(unseen.high, time_of(still_us + 60'000));
  EXPECT_GT(slip_end(rings, exactly(touch_onset_us)).time.at, time_of(still_us + 100'000)) << "else this asks nothing";
  const alignment::UncertainTime ringing = slip_end(rings, exactly(touch_onset_us), {}, stop(still_us)).time;
  EXPECT_LE(ringing.at, time_of(still_us + 51'000));
  EXPECT_LE(ringing.low, time_of(still_us - 1'000));
}

TEST(SlipEnd, IsDoubtedWhereTheRecordingEndsBeforeIt) {
  const LitRate lit = test::lit_rate_of(
      2'000, [](double t_us) { return t_us < touch_onset_us ? 0.2 : 40.0; }, 1, 1'000, 2'000, 0.2);
  EXPECT_FALSE(slip_end(lit, exactly(touch_onset_us)).doubt.empty());
}

TEST(TouchEnd, OfAnOnsetAtTheVeryEndIsDoubted) {
  const LitRate lit = test::lit_rate_of(
      1'000, [](double) { return 0.2; }, 1, 990, 1'000, 0.2);
  for (const FoundTime& found : {press_end(lit, exactly(199'800)), slip_end(lit, exactly(199'800))}) {
    EXPECT_FALSE(found.doubt.empty());
    EXPECT_GE(found.time.at, time_of(199'800));
  }
}

}  // namespace
}  // namespace tactile::labels
