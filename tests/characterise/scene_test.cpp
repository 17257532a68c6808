#include "tactile/characterise/scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "characterise/made_sensor.hpp"
#include "support/error_of.hpp"
#include "support/real_recordings.hpp"
#include "support/temporary_folder.hpp"

namespace tactile::characterise {
namespace {

using namespace std::chrono_literals;

constexpr double pixels = 80 * 60;

/// One second of a sensor. @param hz  events/s of all pixels
test::MadeSensor quiet_sensor(double hz) {
  test::MadeSensor sensor;
  sensor.seconds = 1;
  sensor.background_hz = hz / pixels;
  sensor.shape = 1;
  sensor.spread_decades = 0;
  return sensor;
}

Scene scene_of_sensor(const test::MadeSensor& sensor, std::uint64_t seed = 1) {
  return scene_of(events_of(sensor, seed), sensor.seconds, sensor.size);
}

/// Adds `rate` events/s from `begin` to `end` [s after the first event].
std::vector<events::Event> with_touch(std::vector<events::Event> events, double begin, double end, double rate) {
  Random random(5);
  const CameraTime first = events.front().t;
  for (double t = begin; t < end; t += 1 / rate) {
    events.push_back({after(first, microseconds{std::llround(1e6 * t)}), static_cast<std::int16_t>(random.below(80)),
                      static_cast<std::int16_t>(random.below(60)), 1});
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return events;
}

/// Background 29 to 37 kev/s, 2 to 9 hot pixels, flicker up to 0.06, read-outs of 196 to 201 us.
SceneRanges training() {
  SceneRanges ranges;
  ranges.add_run(std::vector<Scene>{{29'100, 2, 0, 0, 196.0}});
  ranges.add_run(std::vector<Scene>{{37'200, 9, 100, 0.06, 201.0}});
  return ranges;
}

constexpr Scene usual{33'000, 5, 0, 0, 198.0};

TEST(Scene, HasTheBackgroundOfItsNoise) {
  for (const double hz : {30'000.0, 167'000.0}) {
    const Scene scene = scene_of_sensor(quiet_sensor(hz));
    EXPECT_NEAR(scene.background_hz / hz, 1, 0.03) << hz;
    EXPECT_EQ(scene.hot_pixels, 0) << hz;
    EXPECT_EQ(scene.flicker_depth, 0) << hz;
    ASSERT_TRUE(scene.readout_us);
    EXPECT_NEAR(*scene.readout_us, 195.163, 0.05) << hz;
  }
}

TEST(Scene, HasTheSameBackgroundDuringATouchThatPauses) {
  const test::MadeSensor sensor = quiet_sensor(30'000);
  const std::vector<events::Event> quiet = events_of(sensor, 1);
  const Scene touched = scene_of(with_touch(quiet, 0.05, 0.85, 200'000), 1, sensor.size);
  EXPECT_NEAR(touched.background_hz / 30'000, 1, 3 / std::sqrt(600.0))
      << "a press of 0.8 s with seven times the events; 3 standard deviations of a bin";
  EXPECT_EQ(touched.hot_pixels, 0);
  const Scene covered = scene_of(with_touch(quiet, 0, 1, 200'000), 1, sensor.size);
  EXPECT_NEAR(covered.background_hz / 230'000, 1, 0.06) << "nothing is quiet in it";
}

TEST(Scene, CountsHotPixelsAndLeavesMaskedOnesOut) {
  test::MadeSensor sensor = quiet_sensor(30'000);
  sensor.hot = {{10, 10, 800}, {40, 30, 1500}, {70, 50, 600}};
  const std::vector<events::Event> events = events_of(sensor, 2);
  EXPECT_EQ(scene_of(events, 1, sensor.size).hot_pixels, 3);
  EXPECT_EQ(scene_of(events, 1, sensor.size, {{40, 30}, {70, 50}}).hot_pixels, 1);
}

TEST(Scene, FindsFlicker) {
  test::MadeSensor sensor = quiet_sensor(60'000);
  sensor.flicker_hz = 100;
  sensor.flicker_depth = 0.5;
  const Scene scene = scene_of_sensor(sensor);
  EXPECT_NEAR(scene.flicker_hz, 100, 2);
  EXPECT_NEAR(scene.flicker_depth, 0.5, 0.1);
  EXPECT_NEAR(scene.background_hz / 60'000, 1, 0.05) << "bins of 20 ms hold two periods";
}

TEST(Scene, TakesNoVibrationOfATouchForFlicker) {
  const test::MadeSensor sensor = quiet_sensor(30'000);
  std::vector<events::Event> events = events_of(sensor, 1);
  for (double t = 0.3; t < 0.7; t += 1 / 60.0) events = with_touch(std::move(events), t, t + 0.004, 400'000);
  EXPECT_EQ(scene_of(events, 1, sensor.size).flicker_depth, 0);
}

TEST(Scene, OfAnAsynchronousSensorHasNoReadOuts) {
  Random random(3);
  for (const double hz : {33'000.0, 167'000.0}) {
    std::vector<events::Event> events;
    for (double t = 0; t < 1e6; t += random.exponential() * 1e6 / hz) {
      events.push_back({camera_time(std::llround(t)), static_cast<std::int16_t>(random.below(80)),
                        static_cast<std::int16_t>(random.below(60)), 1});
    }
    EXPECT_EQ(scene_of(events, 1, {80, 60}).readout_us.value_or(0), 0) << hz;
  }
}

TEST(Scene, OfNoEventsIsEmpty) {
  const Scene scene = scene_of({}, 1, {80, 60});
  EXPECT_EQ(scene.background_hz, 0);
  EXPECT_EQ(scene.hot_pixels, 0);
  EXPECT_FALSE(scene.readout_us);
  EXPECT_EQ(json_of(scene).at("readout_us"), nullptr);
}

TEST(Scene, OfRealCamerasIsThatOfTheWholeRecording) {
  const auto file = test::real_recording("derived/dvxplorer640_libcaer_rollover.aedat4");
  if (file.empty()) GTEST_SKIP() << test::not_tested_without("derived/dvxplorer640_libcaer_rollover.aedat4");
  events::RecordingReader recording(file);
  const std::vector<Scene> scenes = scenes_of(recording);
  ASSERT_EQ(scenes.size(), 2U);
  for (const Scene& scene : scenes) {
    EXPECT_NEAR(scene.background_hz, 167'167, 2'500);
    EXPECT_NEAR(scene.hot_pixels, 130, 20) << "in a second there are fewer events to tell them";
    ASSERT_TRUE(scene.readout_us);
    EXPECT_NEAR(*scene.readout_us, 195.163, 0.05);
    EXPECT_EQ(scene.flicker_depth, 0);
  }
  EXPECT_EQ(departures(scenes, training()).rfind("background 167 kev/s, training 29 to 37; ", 0), 0U);
}

TEST(SceneWindow, HoldsOneSecond) {
  SceneWindow window;
  std::vector<events::Event> events;
  for (std::int64_t us = 500; us < 2'500'000; us += 100) events.push_back({camera_time(us), 1, 1, 1});
  EXPECT_EQ(window.add(std::span(events).first(4'999)), 4'999U);
  EXPECT_FALSE(window.is_full());
  EXPECT_FALSE(window.is_half_full());
  EXPECT_EQ(window.add(std::span(events).subspan(4'999, 2)), 2U);
  EXPECT_TRUE(window.is_half_full());
  EXPECT_DOUBLE_EQ(window.seconds(), 0.5);
  EXPECT_EQ(window.add(std::span(events).subspan(5'001)), 4'999U) << "[500 us, 1 000 500 us)";
  EXPECT_TRUE(window.is_full());
  EXPECT_EQ(window.seconds(), 1);
  EXPECT_EQ(window.events().back().t, camera_time(1'000'400));
  EXPECT_EQ(window.add(events), 0U) << "it is full";
  window.clear();
  EXPECT_EQ(window.add(std::span(events).subspan(10'000)), 10'000U);
}

TEST(SceneWindow, IsShorterThanASecondWhenTooManyEventsCome) {
  SceneWindow window;
  std::vector<events::Event> events(SceneWindow::most_events + 1000);
  for (std::size_t i = 0; i < events.size(); ++i) events[i].t = camera_time(static_cast<std::int64_t>(i / 2));
  EXPECT_EQ(window.add(events), SceneWindow::most_events);
  EXPECT_TRUE(window.is_full());
  EXPECT_NEAR(window.seconds(), 0.262, 0.001);
  const Scene scene = scene_of(window.events(), window.seconds(), {80, 60});
  EXPECT_NEAR(scene.background_hz, 2e6, 0.02e6);
}

TEST(SceneWindow, TakesTimesAtTheEndOfTheClock) {
  SceneWindow window;
  const std::vector<events::Event> events{{CameraTime::max(), 1, 1, 1}};
  EXPECT_EQ(window.add(events), 1U);
  EXPECT_FALSE(window.is_full());
}

TEST(SceneRanges, AreOfTheMedianWindowForWhatATouchCanRaise) {
  SceneRanges ranges;
  ranges.add_run(std::vector<Scene>{{30'000, 3, 0, 0, 196.0}, {31'000, 4, 80, 0.3, {}}, {90'000, 60, 0, 0, 200.0}});
  EXPECT_EQ(ranges.background_hz, (SceneRanges::Range{31'000, 31'000}));
  EXPECT_EQ(ranges.hot_pixels, (SceneRanges::Range{4, 4}));
  EXPECT_EQ(ranges.flicker_depth, (SceneRanges::Range{0, 0.3}));
  EXPECT_EQ(ranges.readout_us, (SceneRanges::Range{196, 200}));
  ranges.add_run({});
  EXPECT_EQ(ranges.runs, 1U);
}

TEST(SceneRanges, AreReadBackAsTheyWereWritten) {
  const nlohmann::json json = training();
  EXPECT_EQ(json.get<SceneRanges>(), training());
  SceneRanges without = training();
  without.readout_us.reset();
  EXPECT_EQ(nlohmann::json(without).get<SceneRanges>(), without);
}

TEST(SceneRanges, RefuseWhatIsNoRange) {
  for (const nlohmann::json& pair : {nlohmann::json{2, 1}, nlohmann::json{-1, 1}, nlohmann::json{1}, nlohmann::json("a")}) {
    nlohmann::json json = training();
    json["hot_pixels"] = pair;
    EXPECT_THROW(json.get<SceneRanges>(), std::exception) << pair;
  }
  nlohmann::json json = training();
  json.erase("background_hz");
  EXPECT_EQ(test::error_of([&] { json.get<SceneRanges>(); }).substr(0, 5), "scene");
}

TEST(Departures, NameEachFigureThatLeavesTheTrainingRuns) {
  EXPECT_EQ(departures(usual, training()), "");
  Scene scene = usual;
  scene.background_hz = 167'000;
  EXPECT_EQ(departures(scene, training()), "background 167 kev/s, training 29 to 37");
  scene.background_hz = 3'140;
  EXPECT_EQ(departures(scene, training()), "background 3.1 kev/s, training 29 to 37");
  scene = usual;
  scene.hot_pixels = 130;
  EXPECT_EQ(departures(scene, training()), "130 hot pixels, training 2 to 9");
  scene = usual;
  scene.flicker_hz = 100.2, scene.flicker_depth = 0.62;
  EXPECT_EQ(departures(scene, training()), "flicker of 100 Hz with a depth of 0.62, training at most 0.06");
  scene.background_hz = 90'000;
  EXPECT_EQ(departures(scene, training()),
            "background 90 kev/s, training 29 to 37; flicker of 100 Hz with a depth of 0.62, training at most 0.06");
}

TEST(Departures, OfReadOutsNeedAnotherPeriod) {
  Scene scene = usual;
  scene.readout_us = 500.3;
  EXPECT_EQ(departures(scene, training()), "read-outs every 500.3 us, training every 196.0 to 201.0 us");
  scene.readout_us = 0;
  EXPECT_EQ(departures(scene, training()), "no read-outs, training every 196.0 to 201.0 us");
  scene.readout_us = {};
  EXPECT_EQ(departures(scene, training()), "") << "too few events to tell";
  SceneRanges without;
  without.add_run(std::vector<Scene>{{33'000, 5, 0, 0, 0.0}});
  scene.readout_us = 198;
  EXPECT_EQ(departures(scene, without), "read-outs every 198.0 us, training without");
  scene.readout_us = 0;
  EXPECT_EQ(departures(scene, without), "");
}

TEST(Departures, LeaveAMarginForTheNextRun) {
  Scene scene = usual;
  scene.background_hz = 1.49 * 37'200, scene.hot_pixels = 28, scene.flicker_depth = 0.18, scene.readout_us = 220;
  EXPECT_EQ(departures(scene, training()), "");
  scene.background_hz = 29'100 / 1.49, scene.hot_pixels = 0, scene.readout_us = 180;
  EXPECT_EQ(departures(scene, training()), "");
}

TEST(Departures, OfARunNeedTwoWindowsUnlessItHasOne) {
  Scene loud = usual;
  loud.background_hz = 167'000;
  const std::string text = "background 167 kev/s, training 29 to 37";
  EXPECT_EQ(departures(std::vector{loud}, training()), text);
  EXPECT_EQ(departures(std::vector{usual, loud, usual, loud}, training()), "");
  EXPECT_EQ(departures(std::vector{usual, loud, loud, usual}, training()), text);
  EXPECT_EQ(departures(std::vector<Scene>{}, training()), "");
}

TEST(SceneState, LeavesAndReturnsOnce) {
  Scene loud = usual;
  loud.background_hz = 167'000;
  SceneState state(training());
  std::vector<std::string> lines;
  const auto next = [&](const Scene& scene) {
    if (const auto change = state.next(scene)) lines.push_back((change->leaves ? "leaves: " : "returns: ") + change->text);
  };
  for (const Scene& scene : {usual, loud, usual}) next(scene);
  EXPECT_TRUE(lines.empty()) << "a touch may cover a window";
  for (int i = 0; i < 10; ++i) next(loud);
  EXPECT_TRUE(state.is_outside());
  next(usual);
  EXPECT_TRUE(state.is_undecided());
  for (int i = 0; i < 10; ++i) next(usual);
  const std::vector<std::string> expected{"leaves: background 167 kev/s, training 29 to 37",
                                          "returns: as in training again, background 33 kev/s, training 29 to 37"};
  EXPECT_EQ(lines, expected);
}

}  // namespace
}  // namespace tactile::characterise
