#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "tactile/alignment/film_motions.hpp"
#include "tactile/alignment/film_of_arm.hpp"
#include "tactile/core/random.hpp"

namespace tactile::alignment {
namespace {

/// A motion along a straight line: speeds up, moves evenly, slows down.
struct FilmedMotion {
  double start_s = 0, end_s = 0, speed = 1, ramp_s = 0.06;

  double travel(double t_s) const {
    const auto ramped = [&](double u) { return u <= 0 ? 0.0 : u < ramp_s ? 0.5 * u * u / ramp_s : u - 0.5 * ramp_s; };
    return speed * (ramped(t_s - start_s) - ramped(t_s - end_s + ramp_s));
  }
  double speed_at(double t_s) const { return (travel(t_s + 1e-5) - travel(t_s - 1e-5)) / 2e-5; }
};

constexpr std::int64_t run_begin_us = 1'700'000'000'000'000;

struct MadeFilm {
  std::vector<FilmedMotion> motions = {};  ///< in seconds from the run's start, in camera time
  double begins_s = -0.7;                  ///< the first frame
  double ends_s = 5;
  double rate_hz = 30;
  double drift_ppm = 0;
  double jitter = 0.05;        ///< of the times, in frames; 0: they count frames
  int repeats = 0;             ///< one time in so many repeats the one before, and its frame is dropped
  double gain_scatter = 0.03;  ///< of what a step shows of the displacement, relative
  std::uint64_t seed = 1;

  /// Camera time less video time, at the film's start.
  std::int64_t offset_us() const { return run_begin_us + std::llround(1e6 * begins_s); }
};

MotionEnergy film_of(const MadeFilm& made) {
  Random random(made.seed);
  MotionEnergy energy;
  energy.noise = 0.001;
  energy.threshold = 3;
  energy.median_step = microseconds{std::llround(1e6 / made.rate_hz)};
  VideoTime last{};
  const double camera_per_video = 1 + 1e-6 * made.drift_ppm;
  for (int i = 1;; ++i) {
    const VideoTime next{microseconds{std::llround(1e6 * (i + made.jitter * random.normal()) / made.rate_hz)}};
    if (made.repeats > 0 && i % made.repeats == 0) continue;
    const auto camera_s = [&](VideoTime t) { return made.begins_s + camera_per_video * 1e-6 * static_cast<double>(us_of(t)); };
    if (camera_s(next) > made.ends_s) break;
    double travel = 0;
    for (const FilmedMotion& motion : made.motions) travel += motion.travel(camera_s(next)) - motion.travel(camera_s(last));
    const double change = travel * (1 + made.gain_scatter * random.normal()) + 0.5 * energy.noise * random.uniform();
    MotionStep step;
    step.begin = last;
    step.end = next;
    step.energy = std::max(0.0, change) / (1e-6 * static_cast<double>((next - last).count()));
    step.strongest = 15;
    energy.steps.push_back(step);
    last = next;
  }
  return energy;
}

SeenMotion seen_of(const std::vector<FilmedMotion>& motions, double from_s = -0.5, double to_s = 5) {
  SeenMotion seen;
  seen.begin = camera_time(run_begin_us + std::llround(1e6 * from_s));
  for (double t = from_s; t < to_s; t += 0.004) {  // NOLINT(clang-analyzer-security.FloatLoopCounter)
    double speed = 0;
    for (const FilmedMotion& motion : motions) speed += motion.speed_at(t);
    seen.speed.push_back(0.1 * speed);
  }
  return seen;
}

const FilmedMotion arm_lift{.start_s = 2.1, .end_s = 2.83, .speed = 10};
const FilmedMotion closing{.start_s = 0.9, .end_s = 1.6, .speed = 0.6, .ramp_s = 0.02};

double error_ms(const FittedClock& clock, const MadeFilm& made, VideoTime at) {
  const CameraTime truth =
      camera_time(made.offset_us() + std::llround((1 + 1e-6 * made.drift_ppm) * static_cast<double>(us_of(at))));
  return 1e-3 * static_cast<double>(between(truth, clock.relation.camera_from(at)).count());
}

TEST(VideoClock, IsFoundToAFewMillisecondsWithItsUncertainty) {
  int covered = 0;
  constexpr int films = 40;
  for (int i = 0; i < films; ++i) {
    const MadeFilm made{.motions = {closing, arm_lift}, .begins_s = -1.4 + 0.0317 * i, .seed = static_cast<std::uint64_t>(i + 1)};
    const VideoClockFit fit = fit_video_clock(film_of(made), seen_of({arm_lift}));
    ASSERT_TRUE(fit.clock) << fit.refused;
    EXPECT_GT(fit.likeness, 0.98);
    const double error = error_ms(*fit.clock, made, VideoTime{2s});
    EXPECT_LT(std::abs(error), 4) << i;
    covered += fit.clock->offset_low_us <= made.offset_us() && made.offset_us() <= fit.clock->offset_high_us ? 1 : 0;
    EXPECT_LT(fit.clock->offset_high_us - fit.clock->offset_low_us, 12'000);
    EXPECT_EQ(fit.clock->relation.drift_ppm, 0);
    EXPECT_EQ(fit.clock->relation.reference_us, 0);
  }
  EXPECT_GE(covered, films * 9 / 10);
}

TEST(VideoClock, AllowsForTimesThatDriftOrCountFrames) {
  constexpr double ms_23_in_4_s = 5'750;
  const auto within = [](const FittedClock& clock, const MadeFilm& made, VideoTime t) {
    return std::abs(error_ms(clock, made, t)) <=
           1e-3 * static_cast<double>(clock.uncertainty_at(clock.relation.camera_from(t)).count());
  };
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
      const VideoClockFit fit = fit_video_clock(film, seen_of({arm_lift}));
      ASSERT_TRUE(fit.clock) << fit.refused;
      EXPECT_NEAR(static_cast<double>(fit.clock->found_at_us), 1e6 * (2.465 - made.begins_s), 30'000);
      const VideoTime lift{microseconds{fit.clock->found_at_us}};
      covered += within(*fit.clock, made, film.begin()) && within(*fit.clock, made, lift) && within(*fit.clock, made, film.end())
                     ? 1
                     : 0;
      EXPECT_EQ(fit.remark.starts_with("the times of the film are even"), made.jitter == 0) << fit.remark;
    }
    EXPECT_GE(covered, films * 9 / 10) << kind.drift_ppm << " ppm, jitter " << kind.jitter << ", repeats " << kind.repeats;
  }
}

TEST(VideoClock, IsNoMoreCertainThanTheMotionItIsFoundFrom) {
  SeenMotion seen = seen_of({arm_lift});
  seen.sigma_us = 8'000;
  const VideoClockFit fit = fit_video_clock(film_of({.motions = {arm_lift}}), seen);
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_GT(fit.clock->offset_high_us - fit.clock->offset_low_us, 2 * 1.95 * 8'000);
}

TEST(VideoClock, IsFoundFromHalfAFilm) {
  // It ends in the midst of the lift: only the start is seen.
  const MadeFilm made{.motions = {closing, arm_lift}, .ends_s = 2.55};
  const VideoClockFit fit = fit_video_clock(film_of(made), seen_of({arm_lift}));
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_LT(std::abs(error_ms(*fit.clock, made, VideoTime{2s})), 6);
  EXPECT_LE(fit.clock->offset_low_us, made.offset_us());
  EXPECT_GE(fit.clock->offset_high_us, made.offset_us());
}

TEST(VideoClock, IsRefusedWhereTheLiftIsNotInTheFilm) {
  const VideoClockFit fit = fit_video_clock(
      film_of({.motions = {{.start_s = 0.9, .end_s = 1.35, .speed = 0.6}, arm_lift}, .ends_s = 2.0}), seen_of({arm_lift}));
  EXPECT_FALSE(fit.clock);
  EXPECT_FALSE(fit.refused.empty());
}

TEST(VideoClock, IsRefusedWhereTheFilmMatchesAtTwoOffsets) {
  std::vector<FilmedMotion> alike;
  alike.reserve(6);
  for (int i = 0; i < 6; ++i) alike.push_back({.start_s = 1.5 * i, .end_s = 1.5 * i + 0.7, .speed = 10});
  const MadeFilm made{.motions = alike, .ends_s = 10};
  const MotionEnergy film = film_of(made);
  const SeenMotion seen = seen_of(alike, -2, 12);
  const VideoClockFit fit = fit_video_clock(film, seen);
  EXPECT_FALSE(fit.clock);
  EXPECT_NE(fit.refused.find("at two offsets"), std::string::npos) << fit.refused;
}

TEST(VideoClock, IsRefusedWhereOtherThingsMove) {
  FilmedMotion longer = arm_lift;
  longer.end_s += 0.25;
  const VideoClockFit other = fit_video_clock(film_of({.motions = {arm_lift}}), seen_of({longer}));
  EXPECT_FALSE(other.clock) << "a quarter of a second longer";
  EXPECT_EQ(other.contradiction.words, other.refused);
  EXPECT_NE(other.refused.find("of another recording"), std::string::npos) << other.refused;
  std::vector<FilmedMotion> fidgeting;
  fidgeting.reserve(8);
  for (int i = 0; i < 8; ++i) fidgeting.push_back({.start_s = 0.3 + 0.5 * i, .end_s = 0.42 + 0.5 * i, .speed = 8});
  const VideoClockFit fit = fit_video_clock(film_of({.motions = fidgeting}), seen_of({arm_lift}));
  EXPECT_FALSE(fit.clock);
  EXPECT_FALSE(fit.refused.empty());
  EXPECT_TRUE(fit.contradiction.empty()) << "the film may not show the arm";
}

TEST(VideoClock, IsRefusedWhereNothingMoves) {
  EXPECT_EQ(fit_video_clock(film_of({.motions = {arm_lift}}), seen_of({})).refused, "nothing moves that the film should show");
  EXPECT_EQ(fit_video_clock(film_of({.motions = {arm_lift}}), SeenMotion{}).refused,
            "nothing is known of the motion that the film should show");
  MotionEnergy still = film_of({.motions = {}});
  for (MotionStep& step : still.steps) step.energy = 0;
  EXPECT_EQ(fit_video_clock(still, seen_of({arm_lift})).refused, "nothing moves in the film");
  EXPECT_EQ(fit_video_clock(MotionEnergy{}, seen_of({arm_lift})).refused,
            "the film has 0 steps from frame to frame; expected at least 8");
}

TEST(VideoClock, HasADriftOnlyWhereMotionsOverAMinuteAllowIt) {
  std::vector<FilmedMotion> lifts;
  for (const double at_s : {3.0, 21.0, 46.0, 77.0, 118.0, 151.0})
    lifts.push_back({.start_s = at_s, .end_s = at_s + 0.8, .speed = 10});
  const MadeFilm made{.motions = lifts, .ends_s = 160, .drift_ppm = 80};
  const VideoClockFit fit = fit_video_clock(film_of(made), seen_of(lifts, -0.5, 160));
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_EQ(fit.clock->anchors, 6);
  EXPECT_NEAR(fit.clock->relation.drift_ppm, 80, 30);
  EXPECT_LT(std::abs(error_ms(*fit.clock, made, VideoTime{80s})), 3);

  const MadeFilm broken{.motions = lifts, .ends_s = 160, .drift_ppm = 340};
  EXPECT_FALSE(fit_video_clock(film_of(broken), seen_of(lifts, -0.5, 160)).clock);
}

TEST(VideoClock, IsFoundAtTheEndsOfTime) {
  const MadeFilm made{.motions = {arm_lift}};
  for (const std::int64_t begin_us :
       {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max() - 7'000'000}) {
    SeenMotion seen = seen_of({arm_lift});
    const std::int64_t moved = saturating_subtract(begin_us, us_of(seen.begin));
    seen.begin = camera_time(begin_us);
    const VideoClockFit fit = fit_video_clock(film_of(made), seen);
    if (begin_us < 0) {  // video time 0 lies before the first camera time there is
      EXPECT_TRUE(fit.clock || !fit.refused.empty());
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
  SeenMotion seen = seen_of({arm_lift});
  seen.begin = camera_time(std::numeric_limits<std::int64_t>::min() + 5);
  EXPECT_EQ(fit_video_clock(film, seen).refused, "the two clocks lie further apart than 64 bits of microseconds");
}

FittedClock clock_of(const MadeFilm& made, std::int64_t within_us = 2'000) {
  FittedClock clock;
  clock.relation.offset_us = made.offset_us();
  clock.offset_low_us = made.offset_us() - within_us;
  clock.offset_high_us = made.offset_us() + within_us;
  return clock;
}

UncertainTime certain(double t_s) {
  const CameraTime t = camera_time(run_begin_us + std::llround(1e6 * t_s));
  return {t, t, t};
}

bool holds(const UncertainTime& interval, double t_s) {
  return interval.low <= certain(t_s).at && certain(t_s).at <= interval.high;
}

TEST(VideoMotions, StartAndEndWithinTheirIntervals) {
  int starts = 0, ends = 0;
  constexpr int films = 30;
  for (int i = 0; i < films; ++i) {
    const MadeFilm made{
        .motions = {closing, arm_lift}, .begins_s = -1.2 + 0.0131 * i, .seed = static_cast<std::uint64_t>(100 + i)};
    const std::vector<VideoMotion> motions = video_motions(film_of(made), clock_of(made));
    ASSERT_EQ(motions.size(), 2U);
    EXPECT_FALSE(motions[0].start_cut || motions[0].end_cut || motions[1].start_cut || motions[1].end_cut);
    const std::optional<UncertainTime> lift_start = video_start_near(motions, certain(arm_lift.start_s + 0.02), 100ms);
    const UncertainTime& closed = motions[0].end;
    ASSERT_TRUE(lift_start);
    EXPECT_LT(between(lift_start->low, lift_start->high), 70ms);
    starts += holds(*lift_start, arm_lift.start_s) ? 1 : 0;
    ends += holds(closed, closing.end_s) ? 1 : 0;
    EXPECT_FALSE(video_start_near(motions, certain(4.0), 100ms));
  }
  EXPECT_GE(starts, films * 9 / 10);
  EXPECT_GE(ends, films * 9 / 10);
}

TEST(VideoMotions, AreLessCertainAwayFromWhereTheClockWasFound) {
  const MadeFilm made{.motions = {closing, arm_lift}};
  FittedClock clock = clock_of(made);
  const auto width_of_closing = [&] {
    const UncertainTime end = video_motions(film_of(made), clock).front().end;
    return between(end.low, end.high);
  };
  const microseconds without = width_of_closing();
  clock.found_at_us = us_of(VideoTime{3'165ms});  // the lift's middle, 1.6 s after the closing ends
  clock.drift_within_ppm = 10'000;
  EXPECT_GT(width_of_closing(), 2 * 14ms);
  EXPECT_GT(width_of_closing(), without);
}

TEST(VideoMotions, GiveNoStartThatTheFilmDoesNotShow) {
  const MadeFilm made{.motions = {arm_lift}, .begins_s = 2.4};
  const std::vector<VideoMotion> motions = video_motions(film_of(made), clock_of(made));
  ASSERT_EQ(motions.size(), 1U);
  EXPECT_TRUE(motions[0].start_cut);
  EXPECT_FALSE(motions[0].end_cut);
  EXPECT_FALSE(video_start_near(motions, certain(2.4), 1s));
}

TEST(VideoMotions, IgnoreChangesOfTheWholePicture) {
  MotionEnergy film = film_of({.motions = {arm_lift}});
  MotionStep& step = film.steps[20];
  step.energy = 200 * film.noise / (1e-6 * static_cast<double>((step.end - step.begin).count()));
  EXPECT_EQ(video_motions(film, clock_of({})).size(), 2U);
  step.doubtful = true;
  EXPECT_EQ(video_motions(film, clock_of({})).size(), 1U);
}

TEST(VideoMotions, ThatAreFaintGiveNoOnset) {
  MotionEnergy film = film_of({.motions = {arm_lift}});
  for (MotionStep& step : film.steps) step.strongest = film.threshold;
  const std::vector<VideoMotion> motions = video_motions(film, clock_of({}));
  ASSERT_EQ(motions.size(), 1U);
  EXPECT_TRUE(motions[0].faint);
  EXPECT_FALSE(video_start_near(motions, certain(arm_lift.start_s), 200ms));
}

TEST(SeenMotion, IsTheArmsSpeedThroughItsClock) {
  ArmMotion arm;
  arm.begin = RobotTime{500s};
  Random random(4);
  for (int i = 0; i < 2'000; ++i) {
    const double noise = 2e-4, speed = i >= 1'500 && i < 1'600 ? 0.08 : 0.0;
    arm.velocity.push_back({noise * random.normal(), noise * random.normal(), speed + noise * random.normal()});
    arm.acceleration.push_back({});
    arm.known.push_back(true);
  }
  FittedClock clock;
  clock.relation = {.offset_us = run_begin_us - 500'000'000, .drift_ppm = 100, .reference_us = 500'000'000};
  clock.offset_low_us = clock.relation.offset_us - 1'960;
  clock.offset_high_us = clock.relation.offset_us + 1'960;
  const CameraSpan move{camera_time(run_begin_us + 6'000'600), camera_time(run_begin_us + 6'400'600)};
  const SeenMotion seen = seen_motion(arm, {&move, 1}, clock);
  EXPECT_EQ(us_of(seen.begin), run_begin_us);
  EXPECT_NEAR(seen.sigma_us, 1'000, 1);
  const auto first = std::find_if(seen.speed.begin(), seen.speed.end(), [](double v) { return v > 0; });
  ASSERT_NE(first, seen.speed.end());
  const auto index = first - seen.speed.begin();
  // 6 s in, where the drift has come to 0.6 ms.
  EXPECT_NEAR(static_cast<double>(index) * 4e-3, 6.0006, 0.0041);
  EXPECT_NEAR(*(first + 50), 0.08, 0.002);
  EXPECT_EQ(std::count_if(seen.speed.begin(), first, [](double v) { return v != 0; }), 0) << "a resting arm's noise is no motion";
  EXPECT_TRUE(seen_motion(ArmMotion{}, {}, clock).speed.empty());
}

}  // namespace
}  // namespace tactile::alignment
