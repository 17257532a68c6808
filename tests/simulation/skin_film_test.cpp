#include "tactile/simulation/skin_film.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "drawn_runs.hpp"

namespace tactile::simulation {
namespace {

/// A run in memory: its motion and events.
struct Filmed {
  SkinMotion motion;
  FilmedSkin summary;
  std::vector<events::Event> events;
  CameraTime start = camera_time(1'700'000'000'000'000);

  Filmed(const RunPlan& plan, std::uint64_t seed) {
    Random random(seed);
    const EventCameraOptions options;
    motion = move_skin(plan, view_of(options), 200us, random);
    const CameraPixels pixels = draw_camera_pixels(options, 11);
    SkinFilm film(motion, pixels, options, start, seed);
    film_whole(film, [&](std::span<const events::Event> batch) { events.insert(events.end(), batch.begin(), batch.end()); });
    EXPECT_TRUE(film.ended());
    EXPECT_EQ(film.share_done(), 1.0);
    summary = film.filmed();
  }

  const MarkerMotion& the(const std::string& what) const {
    const auto found =
        std::find_if(motion.motions.begin(), motion.motions.end(), [&](const MarkerMotion& one) { return one.what == what; });
    if (found == motion.motions.end()) throw std::runtime_error("no " + what);
    return *found;
  }

  /// Events per second with from <= t < to, since the start.
  double rate(microseconds from, microseconds to) const {
    const auto at = [&](microseconds t) {
      return std::lower_bound(events.begin(), events.end(), start + t,
                              [](const events::Event& event, CameraTime when) { return event.t < when; });
    };
    return 1e6 * static_cast<double>(at(to) - at(from)) / static_cast<double>((to - from).count());
  }
};

TEST(SkinFilm, AgreesWithTheTruth) {
  RunPlanOptions options = short_runs();
  options.after.micro_slips_per_s = 0;
  options.after.recontact_chance = 0;
  options.after.relaxation_share = {0, 0};
  for (const char* object : {"white-box", "plastic-container", "uhu-glue-stick"}) {
    SCOPED_TRACE(object);
    const Filmed run(drawn_plan(default_physics().object(object), options, 3), 3);
    const MarkerMotion &press = run.the("press"), &slip = run.the("slip");
    const double baseline = run.rate(0us, press.start);
    EXPECT_GT(baseline, 1e4);
    EXPECT_LT(baseline, 1e5);
    EXPECT_NEAR(run.rate(press.start - 50ms, press.start), baseline, 0.25 * baseline) << "nothing moves before the press starts";
    EXPECT_GT(run.rate(press.start, press.start + 50ms), 1.5 * baseline);
    EXPECT_NEAR(run.rate(press.end + 5ms, *run.motion.lift_start), baseline, 0.1 * baseline) << "the hold is still";
    EXPECT_GT(run.rate(slip.start, slip.start + 50ms), 3 * baseline);
    EXPECT_EQ(run.summary.events, run.events.size());
    EXPECT_LT(run.summary.caused, run.summary.events);
    EXPECT_TRUE(std::is_sorted(run.events.begin(), run.events.end(),
                               [](const events::Event& a, const events::Event& b) { return a.t < b.t; }));
    EXPECT_EQ(run.summary.last_readout, run.start + 200us * static_cast<std::int64_t>(run.motion.poses.size() - 1));
  }
}

TEST(SkinFilm, FindsTheFirstEventOfEachMotion) {
  RunPlanOptions options = only(&SpecialRuns::taps);
  options.after.micro_slips_per_s = 3;
  options.after.recontact_chance = 1;
  for (const char* object : {"fan", "water-bottle"}) {
    const Filmed run(drawn_plan(default_physics().object(object), options, 3), 3);
    ASSERT_EQ(run.summary.first_events.size(), run.motion.motions.size());
    for (std::size_t i = 0; i < run.motion.motions.size(); ++i) {
      const MarkerMotion& motion = run.motion.motions[i];
      SCOPED_TRACE(std::string(object) + ", " + motion.what + " at " + std::to_string(motion.start.count()));
      const std::optional<CameraTime> first = run.summary.first_events[i];
      if (motion.labelled || motion.what == "tap" || motion.what == "release") {
        ASSERT_TRUE(first);
        EXPECT_LE(*first, run.start + motion.start + 4ms);
      }
      if (!first) continue;
      EXPECT_GT(*first, run.start + motion.start);
      EXPECT_LE(*first, run.start + motion.end);
      EXPECT_TRUE(std::binary_search(run.events.begin(), run.events.end(), events::Event{.t = *first},
                                     [](const events::Event& a, const events::Event& b) { return a.t < b.t; }))
          << "there is an event at that time";
    }
  }
}

TEST(SkinFilm, GivesWhatOnlySomeMarkersCauseToTheirMotion) {
  RunPlan plan;
  PressPlan press;
  press.contact_s = -10;
  press.press_s = 0.2;
  press.depth_mm = 1;
  press.markers[0].pull_x = press.markers[8].pull_x = 0.5;
  plan.presses = {press};
  plan.micro_slips = {{.at_s = 0.1, .markers = 1U << 0, .slip_mm = 0.2}, {.at_s = 0.12, .markers = 1U << 8, .slip_mm = 0.2}};
  plan.end_s = 0.3;
  const Filmed run(plan, 1);
  ASSERT_EQ(run.motion.motions.size(), 2U);
  ASSERT_TRUE(run.summary.first_events[0] && run.summary.first_events[1]);
  EXPECT_LT(*run.summary.first_events[0], run.start + 105ms);
  EXPECT_GT(*run.summary.first_events[1], run.start + 120ms) << "although the first still rings";
  EXPECT_LT(*run.summary.first_events[1], run.start + 125ms);
}

TEST(SkinFilm, IsTheSameForTheSameSeed) {
  const RunPlan plan = drawn_plan(default_physics().objects.front(), short_runs(), 4);
  const Filmed one(plan, 1), again(plan, 1), other(plan, 2);
  ASSERT_EQ(one.events.size(), again.events.size());
  EXPECT_TRUE(std::equal(
      one.events.begin(), one.events.end(), again.events.begin(),
      [](const events::Event& a, const events::Event& b) { return a.t == b.t && a.x == b.x && a.y == b.y && a.on == b.on; }));
  EXPECT_NE(one.events.size(), other.events.size());
}

TEST(FilmWhole, EndsWhereItsListenerThrows) {
  RunPlan plan;
  plan.end_s = 0.5;
  Random random(1);
  const EventCameraOptions options;
  const SkinMotion motion = move_skin(plan, view_of(options), 200us, random);
  const CameraPixels pixels = draw_camera_pixels(options, 11);
  SkinFilm film(motion, pixels, options, camera_time(0), 1);
  const auto stop = [](double share) {
    if (share > 0.3) throw std::runtime_error("stop");
  };
  EXPECT_THROW(film_whole(
                   film, [](std::span<const events::Event>) {}, stop),
               std::runtime_error);
  EXPECT_FALSE(film.ended());
}

}  // namespace
}  // namespace tactile::simulation
