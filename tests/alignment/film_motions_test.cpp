#include "tactile/alignment/film_motions.hpp"

#include <gtest/gtest.h>

#include "made_film.hpp"

namespace tactile::alignment {
namespace {

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

}  // namespace
}  // namespace tactile::alignment
