#include "tactile/evaluation/baselines.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::evaluation {
namespace {

TickEvents events(std::uint32_t on, std::uint32_t off = 0) { return {.on = on, .off = off}; }

TEST(EventRate, CountsTheLastTenMilliseconds) {
  const std::vector<TickEvents> ticks{events(1), events(0, 2), events(4), events(8), events(16), events(32), events(64)};
  const std::vector<double> scores = event_rate_scores(ticks, 2ms);
  EXPECT_DOUBLE_EQ(scores[0], std::log1p(1));
  EXPECT_DOUBLE_EQ(scores[4], std::log1p(31)) << "five ticks, both polarities";
  EXPECT_DOUBLE_EQ(scores[6], std::log1p(4 + 8 + 16 + 32 + 64));
  EXPECT_DOUBLE_EQ(event_rate_scores(ticks, 20ms)[3], std::log1p(8)) << "one tick at least";
}

TEST(Cusum, RisesWhileThereAreMoreEventsAndFallsBack) {
  const double quiet = 10, ln2 = std::numbers::ln2;
  const std::vector<TickEvents> ticks{events(10), events(30), events(200), events(0)};
  const std::vector<double> scores = cusum_scores(ticks, quiet);
  EXPECT_DOUBLE_EQ(scores[0], 0) << "10 ln 2 is below 10";
  EXPECT_DOUBLE_EQ(scores[1], std::log1p(30 * ln2 - 10));
  EXPECT_DOUBLE_EQ(scores[2], std::log1p(230 * ln2 - 20));
  EXPECT_DOUBLE_EQ(scores[3], std::log1p(230 * ln2 - 30));
}

TEST(Cusum, BeginsAnewAfterThreeQuietTicksLess) {
  std::vector<TickEvents> ticks(200, events(1000));  // a long touch that leaves a great sum
  ticks.insert(ticks.end(), {events(0), events(0), events(0), events(20)});
  const std::vector<double> scores = cusum_scores(ticks, 10);
  EXPECT_GT(scores[201], std::log(100'000)) << "no limit";
  EXPECT_EQ(scores[202], 0) << "thirty events fewer than in three quiet ticks";
  EXPECT_DOUBLE_EQ(scores[203], std::log1p(20 * std::numbers::ln2 - 10));
}

TEST(LogOdds, OfAScoreHaveTheGreatestLikelihood) {
  // As many touches as not at x, and three of four at x + 1: log-odds 0 and ln 3.
  const std::vector<double> scores{2, 2, 3, 3, 3, 3};
  const LogOddsOfScore rule = fit_log_odds(scores, {false, true, true, true, true, false});
  EXPECT_NEAR(rule.of(2), 0, 1e-4);
  EXPECT_NEAR(rule.of(3), std::log(3), 1e-4);
  // A threshold separates these: the slope stays finite.
  const LogOddsOfScore step = fit_log_odds(std::vector<double>{0, 1, 4, 5}, {false, false, true, true});
  EXPECT_TRUE(std::isfinite(step.slope) && step.of(1) < -2 && step.of(4) > 2) << step.of(1) << ' ' << step.of(4);
}

TEST(TickFeatures, AreLogarithmsCentresAndSpreads) {
  // Two events at x = 0.25 and 0.75, y = 0.5, in the second tick of two; the first has none.
  const std::vector<TickEvents> ticks{{}, {.on = 1, .off = 1, .x = 1, .y = 1, .xx = 0.625, .yy = 0.5}};
  const std::vector<float> features = tick_features(ticks);
  ASSERT_EQ(features.size(), 2 * features_of_tick);
  for (std::size_t i = 0; i < features_of_tick; ++i) EXPECT_EQ(features[i], 0);
  const std::vector<float> expected{std::log(2.0F), std::log(2.0F), 0.5F, 0.5F, 0.25F, 0};
  for (std::size_t window = 0; window < 3; ++window) {
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_NEAR(features[features_of_tick + 6 * window + i], expected[i], 1e-6) << window << ' ' << i;
  }
}

TEST(EventsOfTicks, AreThoseBeforeEachTick) {
  const test::TemporaryFolder folder;
  const std::vector<events::Event> recorded{{.t = camera_time(1'999), .x = 0, .y = 0, .on = true},
                                            {.t = camera_time(2'000), .x = 320, .y = 240, .on = true},
                                            {.t = camera_time(3'999), .x = 160, .y = 120, .on = false},
                                            {.t = camera_time(9'000), .x = 1, .y = 1, .on = true}};
  events::RecordingWriter writer(folder / "events.aedat4", {events::event_stream_declaration({640, 480}, "DVXplorer_TEST")});
  writer.write_events(0, recorded);
  writer.close();
  const auto ticks = events_of_ticks(folder / "events.aedat4", {.first = camera_time(4'000), .count = 2, .tick = 2ms});
  ASSERT_EQ(ticks.size(), 2U);
  EXPECT_EQ(ticks[0].on, 1U) << "in [2000, 4000)";
  EXPECT_EQ(ticks[0].off, 1U);
  EXPECT_FLOAT_EQ(ticks[0].x, 0.5F + 0.25F);
  EXPECT_FLOAT_EQ(ticks[0].yy, 0.25F + 0.0625F);
  EXPECT_EQ(ticks[1].on + ticks[1].off, 0U);
}

TEST(EventsOfTicks, LeaveOutMaskedPixels) {
  const test::TemporaryFolder folder;
  const std::vector<events::Event> recorded{{.t = camera_time(2'000), .x = 3, .y = 4, .on = true},
                                            {.t = camera_time(2'100), .x = 4, .y = 3, .on = true}};
  events::RecordingWriter writer(folder / "events.aedat4", {events::event_stream_declaration({640, 480}, "DVXplorer_TEST")});
  writer.write_events(0, recorded);
  writer.close();
  const TickRange tick{.first = camera_time(4'000), .count = 1, .tick = 2ms};
  EXPECT_EQ(events_of_ticks(folder / "events.aedat4", tick)[0].on, 2U);
  const auto unmasked = events_of_ticks(folder / "events.aedat4", tick, {{3, 4}});
  EXPECT_EQ(unmasked[0].on, 1U);
  EXPECT_FLOAT_EQ(unmasked[0].y, 3.0F / 480);
}

TEST(NearestClasses, ChangeBetweenTouches) {
  Course course;
  const TickRange ticks{.first = camera_time(0), .count = 7, .tick = 100ms};
  EXPECT_EQ(nearest_classes(course, ticks), std::vector(7, Touch::slip)) << "without a touch";
  course.touches = {{Touch::press, camera_time(100'000), camera_time(200'000)},
                    {Touch::slip, camera_time(430'000), camera_time(450'000)}};
  const Touch p = Touch::press, s = Touch::slip;
  EXPECT_EQ(nearest_classes(course, ticks), (std::vector{p, p, p, p, s, s, s})) << "300 ms is nearer to the press";
  course.touches.pop_back();
  EXPECT_EQ(nearest_classes(course, ticks), std::vector(7, p));
  course.lift_without_slip = camera_time(500'000);
  EXPECT_EQ(nearest_classes(course, ticks), (std::vector{p, p, p, p, s, s, s}));
}

/// Touches of 50 ticks with ten times the events, presses on the left and slips on the right.
LearnedRun made_run(std::uint64_t seed) {
  Random random(seed);
  LearnedRun run;
  for (std::size_t k = 0; k < 2000; ++k) {
    const std::size_t phase = k % 200;
    const Touch touch = phase < 50 ? Touch::press : phase >= 100 && phase < 150 ? Touch::slip : Touch::none;
    TickEvents tick;
    const auto count = random.poisson(touch == Touch::none ? 20 : 200);
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto x = static_cast<float>(touch == Touch::press  ? random.uniform(0, 0.5)
                                        : touch == Touch::slip ? random.uniform(0.5, 1)
                                                               : random.uniform());
      ++(random.below(2) == 0 ? tick.on : tick.off);
      tick.x += x, tick.xx += x * x;
    }
    run.ticks.push_back(tick);
    run.truth.push_back(touch);
  }
  return run;
}

TEST(Baselines, FindTouchesAndOnlyTheNetworkTheirClass) {
  const LearnedRun learned = made_run(1), other = made_run(2);
  const Baselines baselines(std::vector<LearnedRun>{learned}, 2ms);
  std::vector<Touch> classes;
  for (const std::optional<Touch>& touch : other.truth) classes.push_back(touch == Touch::slip ? Touch::slip : Touch::press);
  for (std::size_t baseline = 0; baseline < baseline_names.size(); ++baseline) {
    const auto predicted = baselines.predict(baseline, other.ticks, classes);
    ASSERT_EQ(predicted.size(), other.ticks.size());
    double right = 0;
    for (std::size_t k = 0; k < predicted.size(); ++k) right += model::verdict_of(predicted[k]) == *other.truth[k] ? 1 : 0;
    EXPECT_GT(right / static_cast<double>(predicted.size()), 0.85) << baseline_names[baseline];
    const auto again = Baselines(std::vector<LearnedRun>{learned}, 2ms).predict(baseline, other.ticks, classes);
    EXPECT_EQ(again, predicted) << "the same each time";
    std::vector<Touch> other_classes(classes.size(), Touch::slip);
    EXPECT_EQ(baselines.predict(baseline, other.ticks, other_classes) == predicted, baseline == 2) << baseline_names[baseline];
  }
}

TEST(Baselines, NeedTouchesAndTicksWithout) {
  LearnedRun quiet = made_run(1);
  for (std::optional<Touch>& touch : quiet.truth) touch = touch == Touch::none ? touch : std::nullopt;
  EXPECT_THROW(Baselines(std::vector<LearnedRun>{quiet}, 2ms), Error);
  EXPECT_THROW(Baselines({}, 2ms), Error);
}

}  // namespace
}  // namespace tactile::evaluation
