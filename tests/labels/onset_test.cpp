#include "tactile/labels/onset.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "labels/lit_rate_of.hpp"

namespace tactile::labels {
namespace {

constexpr double onset_us = 400'100;
const CameraTime onset = camera_time(1'000'000 + 400'100);

struct OnsetErrors {
  std::vector<double> errors_ms;  ///< absolute, ascending
  std::vector<double> widths_ms;  ///< ascending
  int covered = 0;
  int doubted = 0;

  double error_ms(double share) const { return errors_ms[static_cast<std::size_t>(share * double(errors_ms.size()))]; }
  double width_ms(double share) const { return widths_ms[static_cast<std::size_t>(share * double(widths_ms.size()))]; }
};

/// @param rise  events per read-out above the quiet rate, by the time since the onset [us], which may be below 0
template <class Find>
OnsetErrors errors_over_seeds(double quiet, const std::function<double(double)>& rise, std::uint64_t seeds, const Find& find) {
  OnsetErrors result;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const LitRate lit = test::lit_rate_of(
        5'000, [&](double t_us) { return quiet + (t_us > onset_us + 200'000 ? 0.0 : rise(t_us - onset_us)); }, seed, 2'030, 3'000,
        quiet);
    const FoundTime found = find(lit);
    const alignment::UncertainTime& time = found.time;
    EXPECT_LE(time.low, time.at);
    EXPECT_LE(time.at, time.high);
    result.errors_ms.push_back(std::abs(static_cast<double>(between(onset, time.at).count())) / 1000.0);
    result.widths_ms.push_back(static_cast<double>(between(time.low, time.high).count()) / 1000.0);
    result.covered += time.low <= onset && onset <= time.high ? 1 : 0;
    result.doubted += found.doubt.empty() ? 0 : 1;
  }
  std::sort(result.errors_ms.begin(), result.errors_ms.end());
  std::sort(result.widths_ms.begin(), result.widths_ms.end());
  return result;
}

double blow(double u_us, double events) { return u_us >= 0 ? events : 0.0; }
double start_from_rest(double u_us, double events_per_ms) { return u_us >= 0 ? 1e-3 * u_us * events_per_ms : 0.0; }

FoundTime press(const LitRate& lit) { return press_onset(lit); }
FoundTime slip(const LitRate& lit) { return slip_onset(lit); }

TEST(PressOnset, IsNotAFainterNoiseThatBeganBefore) {
  // Markers that stand elsewhere since an earlier press have a sixth more noise than the whole run has.
  const OnsetErrors found = errors_over_seeds(
      1.0, [](double u) { return 0.17 + blow(u, 10.0); }, 100, press);
  EXPECT_LE(found.error_ms(0.95), 1.0);
  EXPECT_GE(found.covered, 94);
}

TEST(PressOnset, IsNotInTheBurstBefore) {
  // A release of 3 events per read-out ends 100 ms before the press.
  const auto after_release = [](const LitRate& lit) {
    return press_onset(lit, {}, camera_time(1'000'000 + static_cast<std::int64_t>(onset_us) - 100'000));
  };
  const OnsetErrors found = errors_over_seeds(
      1.0, [](double u) { return (u > -250'000 && u < -100'000 ? 3.0 : 0.0) + blow(u, 10.0); }, 100, after_release);
  EXPECT_LE(found.error_ms(0.95), 1.0);
  EXPECT_GE(found.covered, 94);
}

TEST(PressOnset, OfABlowIsFoundToTheReadOut) {
  const OnsetErrors found = errors_over_seeds(
      0.3, [](double u) { return blow(u, 10.0); }, 100, press);
  EXPECT_LE(found.error_ms(0.5), 0.2);
  EXPECT_LE(found.error_ms(0.95), 0.5);
  EXPECT_GE(found.covered, 94);
}

TEST(PressOnset, OfAStartFromRestIsFoundToMilliseconds) {
  const OnsetErrors found = errors_over_seeds(
      3.0, [](double u) { return start_from_rest(u, 4.0); }, 100, press);
  EXPECT_LE(found.error_ms(0.5), 1.0);
  EXPECT_LE(found.error_ms(0.95), 3.0);
  EXPECT_GE(found.covered, 90);
}

TEST(PressOnset, IsThatOfAWeakContactBeforeTheStrongOne) {
  const OnsetErrors found = errors_over_seeds(
      0.2, [](double u) { return blow(u, 0.6) + blow(u - 25'000, 20.0); }, 100, press);
  EXPECT_LE(found.error_ms(0.5), 1.0);
  EXPECT_LE(found.error_ms(0.95), 5.0);
  EXPECT_GE(found.covered, 90);
}

/// A marker that the noise of all hides, until another one is touched 20 ms later; as one burst, or each place by itself.
LitRate two_markers(std::uint64_t seed, bool told_apart) {
  const auto lit_by = [&](double quiet, double from_us, double events, std::uint64_t of) {
    return test::lit_rate_of(
        5'000, [=](double t_us) { return quiet + (t_us < 600'000 ? blow(t_us - from_us, events) : 0.0); }, of, 2'030, 3'000,
        quiet);
  };
  const LitRate first = lit_by(0.2, onset_us, 0.8, 2 * seed), second = lit_by(3.0, onset_us + 20'000, 30.0, 2 * seed + 1);
  LitRate all = second;
  all.quiet_per_bin = 3.2;
  all.repeats.assign(5'000, 0);
  for (std::size_t i = 0; i < 5'000; ++i) all.rate.counts[i] += first.rate.counts[i];
  for (const LitRate* place : {&second, &first}) {
    if (told_apart) all.places.push_back({place->rate.counts, all.repeats, place->quiet_per_bin, 1.0});
  }
  return all;
}

TEST(PressOnset, IsThatOfTheFirstMarkerWhoseOwnNoiseDoesNotHideIt) {
  std::vector<double> together_ms, apart_ms;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto error_ms = [&](bool told_apart) {
      return std::abs(1e-3 * static_cast<double>(between(onset, press_onset(two_markers(seed, told_apart)).time.at).count()));
    };
    together_ms.push_back(error_ms(false));
    apart_ms.push_back(error_ms(true));
  }
  std::sort(together_ms.begin(), together_ms.end());
  std::sort(apart_ms.begin(), apart_ms.end());
  EXPECT_GT(together_ms[30], 5.0) << "else this asks nothing";
  EXPECT_LT(apart_ms[20], 2.0);
  EXPECT_LT(apart_ms[36], 6.0);
}

TEST(PressOnset, MayLieAsEarlyAsPixelsThatNoiseHasResetAreBlind) {
  LitRate lit = test::lit_rate_of(
      5'000, [](double t_us) { return 0.3 + (t_us < 600'000 ? blow(t_us - onset_us, 10.0) : 0.0); }, 1, 2'030, 3'000, 0.3);
  lit.repeats.assign(5'000, 0);  // none repeats its event: for how long they were blind is not seen
  const alignment::UncertainTime fresh = press_onset(lit).time;
  lit.reset_share = 1.0;
  const alignment::UncertainTime again = press_onset(lit).time;
  EXPECT_EQ(fresh.at, again.at);
  // They are blind for 25 ms more; a press reaches 0.6 of that, since some pixels were near their threshold.
  EXPECT_NEAR(static_cast<double>(between(again.low, fresh.low).count()), 15'000, 500);
}

TEST(PressOnset, MayLieAsEarlyAsThePixelsOfTheFirstPlaceAreBlind) {
  const auto touched_from = [](double from_us, std::uint64_t seed) {
    return test::lit_rate_of(
        5'000, [=](double t_us) { return 0.3 + (t_us < 600'000 ? blow(t_us - from_us, 10.0) : 0.0); }, seed, 2'030, 3'000, 0.3);
  };
  const LitRate first = touched_from(onset_us, 1), second = touched_from(onset_us + 5'000, 2);
  LitRate lit = first;
  lit.quiet_per_bin = 0.6;
  for (std::size_t i = 0; i < 5'000; ++i) lit.rate.counts[i] += second.rate.counts[i];
  const std::vector<std::uint32_t> none(5'000);
  lit.repeats = none;
  lit.places = {{first.rate.counts, none, 0.3, 1.0}, {second.rate.counts, none, 0.3, 1.0}};
  const alignment::UncertainTime blind = press_onset(lit).time;

  const auto all_repeat = [](std::vector<std::uint32_t> counts) {
    std::fill_n(counts.begin(), 2'000, 0U);  // the noise before the touch does not
    return counts;
  };
  lit.repeats = lit.places[1].repeats = all_repeat(second.rate.counts);
  EXPECT_EQ(press_onset(lit).time.low, blind.low) << "the second place says nothing of the first";

  for (std::size_t i = 2'000; i < 5'000; ++i) lit.repeats[i] += first.rate.counts[i];
  lit.places[0].repeats = all_repeat(first.rate.counts);
  const alignment::UncertainTime at_once = press_onset(lit).time;
  EXPECT_EQ(at_once.at, blind.at);
  // 0.6 of the 15 ms for which pixels are blind at most, instead of the latency of 0.4 ms.
  EXPECT_NEAR(static_cast<double>(between(blind.low, at_once.low).count()), 8'600, 500);
}

TEST(SlipOnset, IsTheJumpAfterTheRingingAndNotTheRinging) {
  const auto ringing_then_jump = [](double u) {
    const double since = u + 10'000;  // the arm starts 10 ms ahead
    const double ringing = since < 0 ? 0.0 : 8.0 * std::abs(std::sin(2e-6 * 3.14159265 * 18.0 * since));
    return ringing + blow(u, 30.0) + start_from_rest(u, 3.0);
  };
  const OnsetErrors found = errors_over_seeds(0.3, ringing_then_jump, 100, slip);
  EXPECT_LE(found.error_ms(0.5), 0.3);
  EXPECT_LE(found.error_ms(0.95), 1.0);
  EXPECT_GE(found.covered, 90);
}

TEST(SlipOnset, WithoutRingingIsTheFirstMotion) {
  const OnsetErrors found = errors_over_seeds(
      0.3, [](double u) { return start_from_rest(u, 10.0); }, 100, slip);
  EXPECT_LE(found.error_ms(0.5), 0.7);
  EXPECT_LE(found.error_ms(0.95), 2.0);
  EXPECT_GE(found.covered, 90);
}

TEST(SlipOnset, IsNotBeforeTheLift) {
  const LitRate lit = test::lit_rate_of(
      5'000, [](double t_us) { return 0.3 + blow(t_us - 390'000, 2.0) + blow(t_us - onset_us, 30.0); }, 1, 2'000, 3'000, 0.3);
  const alignment::UncertainTime lift{camera_time(1'398'000), camera_time(1'396'000), camera_time(1'402'000)};
  EXPECT_GE(slip_onset(lit, {}, lift).time.low, before(lift.low, 1ms));
}

TEST(Onset, IsKeptInsideTheRecordingNearItsStart) {
  const LitRate lit = test::lit_rate_of(
      300, [](double t_us) { return t_us < 4'000 ? 3.0 : 50.0; }, 1, 25, 300, 3.0);
  for (const FoundTime& found : {press_onset(lit), slip_onset(lit)})
    EXPECT_NEAR(static_cast<double>(between(lit.rate.begin, found.time.at).count()), 4'000, 400);
}

}  // namespace
}  // namespace tactile::labels
