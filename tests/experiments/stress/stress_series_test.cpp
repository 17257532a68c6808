#include "tactile/experiments/stress/stress_series.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/experiments/stress/simulated_worlds.hpp"
#include "tactile/simulation/simulate.hpp"

namespace tactile::stress {
namespace {

std::vector<events::Event> changed(const StressSeries& series, double severity, const std::string& run,
                                   std::span<const events::Event> events) {
  const heatmaps::ChangeEvents change = change_by(series, severity, run, {64, 48});
  std::vector<events::Event> all;
  const auto take = [&](std::span<const events::Event> some) { all.insert(all.end(), some.begin(), some.end()); };
  take(change(events.first(events.size() / 2), false));
  take(change(events.subspan(events.size() / 2), false));
  take(change({}, true));
  return all;
}

std::vector<events::Event> a_second_of_events() {
  std::vector<events::Event> events;
  for (int i = 0; i < 1000; ++i)
    events.push_back({camera_time(1000 * i), static_cast<std::int16_t>(i % 64), static_cast<std::int16_t>(i % 48), i % 2 == 0});
  return events;
}

TEST(StressSeries, TakesSeveritiesInAnyOrderAndParameters) {
  const StressSeries series = series_in("vibration:3,1:hz=120", 7);
  EXPECT_EQ(series.severities, (std::vector<double>{1, 3}));
  EXPECT_EQ(series.name, "vibration-hz-120");
  ASSERT_EQ(recipes_at(series, 3).size(), 1U);
  EXPECT_EQ(recipes_at(series, 3)[0].severity, 3);
  EXPECT_EQ(recipes::parameter_of(recipes_at(series, 3)[0], "hz"), 120);
}

TEST(StressSeries, HasTheUsualSeveritiesOfTheRecipe) {
  const StressSeries series = series_in("noise", 1);
  const auto usual = recipes::recipe_named("noise").usual;
  EXPECT_EQ(series.severities, std::vector<double>(usual.begin(), usual.end()));
  EXPECT_EQ(with_few_severities(series).severities.size(), 3U);
  EXPECT_EQ(with_few_severities(series).severities.back(), usual.back());
  EXPECT_EQ(all_series(1).size(), recipes::recipe_list().size());
}

TEST(StressSeries, RefusesWrongSeveritiesInOneSentence) {
  EXPECT_EQ(test::error_of([] { series_in("noise:50,50", 1); }),
            "'noise:50,50': the severity 50 is given twice; expected each once");
  EXPECT_EQ(test::error_of([] { series_in("noise:-1", 1); }),
            "'noise:-1': its severity '-1' is no number above 0; expected a list such as noise:10,20");
  EXPECT_NE(test::error_of([] { series_in("nois:50", 1); }).find("noise"), std::string::npos);
  EXPECT_NE(test::error_of([] { world_series_in("light-dimm"); }).find("the nearest is 'light-dim'"), std::string::npos);
  EXPECT_EQ(test::error_of([] { world_series_in("light-dim:100"); }),
            "'light-dim:100': a severity of 100 % of the light lost; expected at most 99");
}

TEST(StressSeries, OfAFileScalesItsSeverities) {
  const test::TemporaryFolder folder;
  const auto file = folder / "Bad day.json";
  write_whole(file, R"({"steps": [{"recipe": "noise", "severity": 200}, {"recipe": "loss", "severity": 40}]})");
  const StressSeries series = series_in(file.string(), 1);
  EXPECT_EQ(series.severities, (std::vector<double>{25, 50, 100}));
  EXPECT_EQ(recipes_at(series, 50)[0].severity, 100);
  EXPECT_EQ(recipes_at(series, 50)[1].severity, 20);
  EXPECT_EQ(recipes_at(series, 100)[1].severity, 40);
}

TEST(StressSeries, DrawsOtherNumbersForEachRunButTheSameAgain) {
  const std::vector<events::Event> events = a_second_of_events();
  const StressSeries series = series_in("loss:50", 1);
  const auto first = changed(series, 50, "fan/01", events);
  EXPECT_GT(first.size(), 400U);
  EXPECT_LT(first.size(), 600U);
  EXPECT_EQ(first, changed(series, 50, "fan/01", events));
  EXPECT_NE(first, changed(series, 50, "fan/02", events));
}

TEST(SimulatedWorlds, AreValidAtEachUsualSeverityAndChangeThePhysics) {
  const simulation::SimulationPhysics& own = simulation::default_physics();
  for (const SimulatedWorld& world : world_list()) {
    for (const double severity : world.usual)
      EXPECT_NE(simulation::json_of(physics_in(world.name, severity, own)), simulation::json_of(own)) << world.name;
    EXPECT_EQ(world_series_in(std::string(world.name)).severities.size(), world.usual.size());
  }
  EXPECT_DOUBLE_EQ(physics_in("light-dim", 75, own).camera.skin, own.camera.skin / 4);
  EXPECT_DOUBLE_EQ(physics_in("motion-fast", 100, own).variation.lift_speed_mm_s.high, 2 * own.variation.lift_speed_mm_s.high);
  EXPECT_EQ(physics_in("camera-noisy", 100, own).camera.hot_pixels, simulation::with_camera("noisy").camera.hot_pixels);
}

TEST(SimulatedWorlds, SimulateTheSameRunAgainAndKeepIt) {
  const test::TemporaryFolder folder;
  const auto made =
      simulation::simulate({.data = folder / "data", .preset = "tiny", .runs = 1, .objects = {"fan"}, .threads = 1});
  const RunFolder run = made.front().run, again = simulated_in_world(run, "light-dim", 1e-9, folder / "worlds");
  const Truth truth = read_truth(run.truth()), other = read_truth(again.truth());
  ASSERT_EQ(truth.intervals.size(), other.intervals.size());
  for (std::size_t i = 0; i < truth.intervals.size(); ++i) {
    EXPECT_EQ(truth.intervals[i].interval.start, other.intervals[i].interval.start) << "hardly another light, the same motion";
    EXPECT_EQ(truth.intervals[i].interval.end, other.intervals[i].interval.end);
  }
  const auto written = std::filesystem::last_write_time(again.events());
  EXPECT_EQ(simulated_in_world(run, "light-dim", 1e-9, folder / "worlds").folder, again.folder);
  EXPECT_EQ(std::filesystem::last_write_time(again.events()), written);
}

}  // namespace
}  // namespace tactile::stress
