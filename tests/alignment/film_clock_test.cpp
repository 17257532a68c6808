#include "tactile/alignment/film_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "made_film.hpp"

namespace tactile::alignment {
namespace {

/// The speed that a film must show.
struct MadeSpeed {
  SeenMotion seen;
  std::vector<float> speed;

  explicit MadeSpeed(const std::vector<MadeMotion>& motions, double from_s = -0.5, double to_s = 5) {
    seen.begin = camera_time(run_begin_us + std::llround(1e6 * from_s));
    for (int i = 0; from_s + 0.004 * i < to_s; ++i) {
      double sum = 0;
      for (const MadeMotion& motion : motions) sum += motion.speed_at(from_s + 0.004 * i);
      speed.push_back(sum < 1e-3 ? 0.0F : static_cast<float>(sum));
    }
    seen.speed = speed;
  }
  MadeSpeed(const MadeSpeed&) = delete;
  MadeSpeed& operator=(const MadeSpeed&) = delete;
};

double error_ms(const FittedClock& clock, const MadeFilm& made, VideoTime at) {
  const CameraTime truth =
      camera_time(made.offset_us() + std::llround((1 + 1e-6 * made.drift_ppm) * static_cast<double>(us_of(at))));
  return 1e-3 * static_cast<double>(between(truth, clock.relation.camera_from(at)).count());
}

VideoTime found_at(const FittedClock& clock) { return VideoTime{microseconds{clock.found_at_us}}; }

bool holds_truth(const FittedClock& clock, const MadeFilm& made, VideoTime at) {
  return std::abs(error_ms(clock, made, at)) <=
         1e-3 * static_cast<double>(clock.uncertainty_at(clock.relation.camera_from(at)).count());
}

bool holds_truth_at_the_ends(const FittedClock& clock, const MadeFilm& made, const MotionEnergy& film) {
  return holds_truth(clock, made, film.begin()) && holds_truth(clock, made, film.end());
}

TEST(FilmClock, IsFoundToAFewMillisecondsWithItsUncertainty) {
  int covered = 0;
  constexpr int films = 40;
  for (int i = 0; i < films; ++i) {
    const MadeFilm made{.motions = {closing, arm_lift}, .begins_s = -1.4 + 0.0317 * i, .seed = static_cast<std::uint64_t>(i + 1)};
    const FilmClock fit = film_clock(film_of(made), MadeSpeed({arm_lift}).seen);
    ASSERT_TRUE(fit.clock) << fit.refused;
    const double error = error_ms(*fit.clock, made, VideoTime{2s});
    EXPECT_LT(std::abs(error), 4) << i;
    covered += fit.clock->offset_low_us <= made.offset_us() && made.offset_us() <= fit.clock->offset_high_us ? 1 : 0;
    EXPECT_LT(fit.clock->offset_high_us - fit.clock->offset_low_us, 18'000);
    EXPECT_EQ(fit.clock->relation.drift_ppm, 0);
    EXPECT_EQ(fit.clock->relation.reference_us, 0);
  }
  EXPECT_GE(covered, films * 9 / 10);
}

TEST(FilmClock, AllowsForTimesThatDriftOrCountFrames) {
  constexpr double ms_23_in_4_s = 5'750;
  for (const MadeFilm& kind : {MadeFilm{.drift_ppm = ms_23_in_4_s}, MadeFilm{.drift_ppm = -ms_23_in_4_s},
                               MadeFilm{.drift_ppm = -ms_23_in_4_s, .jitter = 0},  // a camera of 30.17 frames/s, times of 30
                               MadeFilm{.drift_ppm = ms_23_in_4_s, .jitter = 0, .repeats = 5}, MadeFilm{.repeats = 5}}) {
    int films = 0, covered = 0;
    for (; films < 20; ++films) {
      MadeFilm made = kind;
      made.motions = {closing, arm_lift};
      made.begins_s = -1.4 + 0.0317 * films;
      made.seed = static_cast<std::uint64_t>(films) + 1;
      const MotionEnergy film = film_of(made);
      const FilmClock fit = film_clock(film, MadeSpeed({arm_lift}).seen);
      ASSERT_TRUE(fit.clock) << fit.refused;
      EXPECT_NEAR(static_cast<double>(fit.clock->found_at_us), 1e6 * (2.465 - made.begins_s), 30'000);
      const bool is_covered =
          holds_truth(*fit.clock, made, found_at(*fit.clock)) && holds_truth_at_the_ends(*fit.clock, made, film);
      covered += is_covered ? 1 : 0;
      EXPECT_EQ(fit.remark.starts_with("the times of the film are even"), made.jitter == 0) << fit.remark;
    }
    EXPECT_GE(covered, films * 9 / 10) << kind.drift_ppm << " ppm, jitter " << kind.jitter << ", repeats " << kind.repeats;
  }
}

TEST(FilmClock, IsNoMoreCertainThanTheMotionItIsFoundFrom) {
  const MadeSpeed made({arm_lift});
  SeenMotion seen = made.seen;
  seen.sigma_us = 8'000;
  const FilmClock fit = film_clock(film_of({.motions = {arm_lift}}), seen);
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_GT(fit.clock->offset_high_us - fit.clock->offset_low_us, 2 * 1.95 * 8'000);
}

TEST(FilmClock, IsFoundFromHalfAFilm) {
  // It ends in the midst of the lift: only the start is seen.
  const MadeFilm made{.motions = {closing, arm_lift}, .ends_s = 2.55};
  const FilmClock fit = film_clock(film_of(made), MadeSpeed({arm_lift}).seen);
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_LT(std::abs(error_ms(*fit.clock, made, VideoTime{2s})), 6);
  EXPECT_LE(fit.clock->offset_low_us, made.offset_us());
  EXPECT_GE(fit.clock->offset_high_us, made.offset_us());
}

TEST(FilmClock, IsFoundByTheMotionsThatAreInTheFilm) {
  const std::vector<MadeMotion> two{arm_lift, {.start_s = 33, .end_s = 33.6, .speed = 8}};
  const MadeFilm made{.motions = two, .drift_ppm = 4'000};
  const FilmClock fit = film_clock(film_of(made), MadeSpeed(two, -0.5, 40).seen);
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_EQ(fit.clock->anchors, 1);
  EXPECT_EQ(fit.clock->relation.drift_ppm, 0) << "one motion does not show it";
  EXPECT_LT(std::abs(error_ms(*fit.clock, made, found_at(*fit.clock))), 4);
}

TEST(FilmClock, IsRefusedWhereTheLiftIsNotInTheFilm) {
  const FilmClock fit = film_clock(film_of({.motions = {{.start_s = 0.9, .end_s = 1.35, .speed = 0.6}, arm_lift}, .ends_s = 2.0}),
                                   MadeSpeed({arm_lift}).seen);
  EXPECT_FALSE(fit.clock);
  EXPECT_FALSE(fit.refused.empty());
}

TEST(FilmClock, IsRefusedWhereTheFilmMatchesAtSeveralOffsets) {
  std::vector<MadeMotion> alike;
  alike.reserve(6);
  for (int i = 0; i < 6; ++i) alike.push_back({.start_s = 1.5 * i, .end_s = 1.5 * i + 0.7, .speed = 10});
  const MadeSpeed made(alike, -2, 12);
  EXPECT_EQ(film_clock(film_of({.motions = alike, .begins_s = 2.5, .ends_s = 6.9}), made.seen).refused,
            "the film matches at several offsets");
  EXPECT_TRUE(film_clock(film_of({.motions = alike, .ends_s = 10}), made.seen).clock) << "the rest before and after them is seen";
}

TEST(FilmClock, IsRefusedWhereOtherThingsMove) {
  MadeMotion longer = arm_lift;
  longer.end_s += 0.25;
  const FilmClock other = film_clock(film_of({.motions = {arm_lift}}), MadeSpeed({longer}).seen);
  EXPECT_FALSE(other.clock) << "a quarter of a second longer";
  EXPECT_EQ(other.contradiction.words, other.refused);
  EXPECT_NE(other.refused.find("of another recording"), std::string::npos) << other.refused;
  std::vector<MadeMotion> fidgeting;
  fidgeting.reserve(8);
  for (int i = 0; i < 8; ++i) fidgeting.push_back({.start_s = 0.3 + 0.5 * i, .end_s = 0.42 + 0.5 * i, .speed = 8});
  const FilmClock fit = film_clock(film_of({.motions = fidgeting}), MadeSpeed({arm_lift}).seen);
  EXPECT_EQ(fit.refused, "the motion in the film does not match the arm's");
  EXPECT_TRUE(fit.contradiction.empty()) << "the film may not show the arm";
}

TEST(FilmClock, IsRefusedWhereNothingMoves) {
  EXPECT_EQ(film_clock(film_of({.motions = {arm_lift}}), MadeSpeed({}).seen).refused, "nothing moves that the film should show");
  EXPECT_EQ(film_clock(film_of({.motions = {arm_lift}}), SeenMotion{}).refused,
            "nothing is known of the motion that the film should show");
  MotionEnergy still = film_of({.motions = {}});
  for (MotionStep& step : still.steps) step.energy = 0;
  EXPECT_EQ(film_clock(still, MadeSpeed({arm_lift}).seen).refused, "nothing moves in the film");
  EXPECT_EQ(film_clock(MotionEnergy{}, MadeSpeed({arm_lift}).seen).refused,
            "the film has 0 steps from frame to frame; expected at least 8");
}

TEST(FilmClock, HasADriftWhereSeveralMotionsShowIt) {
  std::vector<MadeMotion> lifts;
  for (const double at_s : {3.0, 21.0, 46.0, 77.0, 118.0, 151.0})
    lifts.push_back({.start_s = at_s, .end_s = at_s + 0.8, .speed = 10});
  const MadeSpeed speed(lifts, -0.5, 160);
  for (const double drift_ppm : {80.0, -340.0, 4'000.0}) {
    const MadeFilm made{.motions = lifts, .ends_s = 160, .drift_ppm = drift_ppm};
    const FilmClock fit = film_clock(film_of(made), speed.seen);
    ASSERT_TRUE(fit.clock) << fit.refused;
    EXPECT_EQ(fit.clock->anchors, 6);
    EXPECT_NEAR(fit.clock->relation.drift_ppm, drift_ppm, fit.clock->drift_within_ppm);
    EXPECT_GT(fit.clock->drift_within_ppm, 2);
    EXPECT_LT(fit.clock->drift_within_ppm, 100);
    EXPECT_LT(std::abs(error_ms(*fit.clock, made, VideoTime{80s})), 3);
  }
}

/// Of 40 films, those whose 95 % interval holds the true time where the clock was found, and at both ends.
struct Covered {
  int found = 0, at_the_ends = 0;
  double half_ms = 0;  ///< mean half width where the clock was found
};

Covered covered_of_40(const std::vector<MadeMotion>& motions, double ends_s, double rate_hz) {
  const MadeSpeed speed(motions, -0.5, ends_s);
  Covered covered;
  for (int i = 0; i < 40; ++i) {
    const MadeFilm made{.motions = motions,
                        .begins_s = -1.4 + 0.0317 * i,
                        .ends_s = ends_s,
                        .rate_hz = rate_hz,
                        .drift_ppm = 600.0 * (i - 20),
                        .seed = static_cast<std::uint64_t>(i + 1)};
    const MotionEnergy film = film_of(made);
    const FilmClock fit = film_clock(film, speed.seen);
    EXPECT_TRUE(fit.clock) << fit.refused;
    if (!fit.clock) continue;
    covered.found += holds_truth(*fit.clock, made, found_at(*fit.clock)) ? 1 : 0;
    covered.at_the_ends += holds_truth_at_the_ends(*fit.clock, made, film) ? 1 : 0;
    covered.half_ms += 1e-3 * static_cast<double>(fit.clock->uncertainty().count()) / 40;
  }
  return covered;
}

const MadeMotion earlier{.start_s = 0.4, .end_s = 0.9, .speed = 8};

TEST(FilmClock, CoversTheTruthHoweverLongNothingMoves) {
  for (const double ends_s : {5.0, 20.0, 40.0}) {
    const Covered two = covered_of_40({earlier, arm_lift}, ends_s, 30);
    EXPECT_GE(two.found, 36) << ends_s;
    EXPECT_GE(two.at_the_ends, 36) << ends_s;
    EXPECT_LT(two.half_ms, 8) << ends_s;
    const Covered one = covered_of_40({arm_lift}, ends_s, 30);
    EXPECT_GE(one.found, 36) << ends_s;
    EXPECT_LT(one.half_ms, 8) << ends_s;
  }
}

TEST(FilmClock, CoversTheTruthAtAnyFrameRate) {
  for (const double rate_hz : {10.0, 60.0, 200.0}) {
    const Covered two = covered_of_40({earlier, arm_lift}, 5, rate_hz);
    EXPECT_GE(two.found, 36) << rate_hz;
    EXPECT_GE(two.at_the_ends, 36) << rate_hz;
  }
}

TEST(FilmClock, IsFoundWhereTheFilmEndsOrBeginsWithinAMove) {
  const std::vector<MadeMotion> two{arm_lift, {.start_s = 4.5, .end_s = 5.5, .speed = 8}};
  const MadeSpeed speed(two, -0.5, 7);
  for (const double ends_s : {4.6, 4.7, 4.8, 4.9, 5.0, 5.2}) {
    const MadeFilm made{.motions = two, .ends_s = ends_s};
    const FilmClock fit = film_clock(film_of(made), speed.seen);
    ASSERT_TRUE(fit.clock) << ends_s << ": " << fit.refused;
    EXPECT_LT(std::abs(error_ms(*fit.clock, made, found_at(*fit.clock))), 5) << ends_s;
  }
  const std::vector<MadeMotion> before{earlier, arm_lift};
  for (const double begins_s : {0.6, 0.7, 0.75}) {
    const FilmClock fit = film_clock(film_of({.motions = before, .begins_s = begins_s}), MadeSpeed(before).seen);
    EXPECT_TRUE(fit.clock) << begins_s << ": " << fit.refused;
  }
}

TEST(FilmClock, IsFoundAcrossAGapOfTheLog) {
  const MadeFilm made{.motions = {arm_lift}};
  for (const std::size_t missing : {30U, 50U, 75U}) {
    MadeSpeed speed({arm_lift});
    std::fill_n(speed.speed.begin() + 710, missing, std::numeric_limits<float>::quiet_NaN());
    speed.seen.speed = speed.speed;
    const FilmClock fit = film_clock(film_of(made), speed.seen);
    ASSERT_TRUE(fit.clock) << missing << ": " << fit.refused;
    EXPECT_EQ(fit.clock->anchors, 1) << "a gap does not end a motion";
    EXPECT_LT(std::abs(error_ms(*fit.clock, made, VideoTime{2s})), 8) << missing;
  }
  MadeSpeed unknown({arm_lift});
  unknown.speed.assign(unknown.speed.size(), std::numeric_limits<float>::quiet_NaN());
  unknown.seen.speed = unknown.speed;
  EXPECT_EQ(film_clock(film_of(made), unknown.seen).refused, "nothing moves that the film should show");
}

TEST(FilmClock, IsRefusedWhereFilmAndLogAreTooLongToBeSearched) {
  const std::vector<MadeMotion> apart{arm_lift, {.start_s = 700, .end_s = 700.6, .speed = 8}};
  EXPECT_TRUE(film_clock(film_of({.motions = apart, .ends_s = 705}), MadeSpeed(apart, -0.5, 705).seen)
                  .refused.starts_with("film and robot log are too long to be compared"));
}

TEST(FilmClock, IsRefusedWhereTheTimesHaveAnotherRate) {
  // Taken at 30 frames/s, with times of 25: each second counts as 1.2 s.
  const std::vector<MadeMotion> two{{.start_s = 0.4, .end_s = 0.9, .speed = 8}, arm_lift};
  const MotionEnergy film = film_of({.motions = two, .rate_hz = 25, .drift_ppm = -1e6 / 6, .jitter = 0});
  EXPECT_EQ(film_clock(film, MadeSpeed(two).seen).refused,
            "the times of the film give 25 frames/s, but by the distance of its motions it has about 30 frames/s; expected times "
            "of the film's own rate");
  const FilmClock right = film_clock(film_of({.motions = two, .jitter = 0}), MadeSpeed(two).seen);
  EXPECT_TRUE(right.remark.starts_with("the times of the film are even")) << right.remark;
  EXPECT_EQ(right.remark.find("frames/s"), std::string::npos) << "two motions show the rate: " << right.remark;
  const FilmClock one = film_clock(film_of({.motions = {arm_lift}, .jitter = 0}), MadeSpeed({arm_lift}).seen);
  EXPECT_TRUE(one.remark.ends_with(", or by more if the film was not taken at 30 frames/s: its motions do not show its rate"))
      << one.remark;
}

TEST(FilmClock, IsFoundAtTheEndsOfTime) {
  const MadeFilm made{.motions = {arm_lift}};
  const MadeSpeed speed({arm_lift});
  for (const std::int64_t begin_us :
       {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max() - 7'000'000}) {
    SeenMotion seen = speed.seen;
    const std::int64_t moved = saturating_subtract(begin_us, us_of(seen.begin));
    seen.begin = camera_time(begin_us);
    const FilmClock fit = film_clock(film_of(made), seen);
    if (begin_us < 0) {  // video time 0 lies before the first camera time there is
      EXPECT_EQ(fit.refused, "the two clocks lie further apart than 64 bits of microseconds");
      continue;
    }
    ASSERT_TRUE(fit.clock) << fit.refused;
    EXPECT_NEAR(static_cast<double>(fit.clock->relation.offset_us - moved - made.offset_us()), 0, 4'000);
  }
  MotionEnergy film = film_of(made);
  for (MotionStep& step : film.steps) {
    step.begin += microseconds{std::numeric_limits<std::int64_t>::max() / 2};
    step.end += microseconds{std::numeric_limits<std::int64_t>::max() / 2};
  }
  SeenMotion seen = speed.seen;
  seen.begin = camera_time(std::numeric_limits<std::int64_t>::min() + 5);
  EXPECT_EQ(film_clock(film, seen).refused, "the two clocks lie further apart than 64 bits of microseconds");
}

}  // namespace
}  // namespace tactile::alignment
