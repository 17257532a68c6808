#include "tactile/characterise/characterise.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include "characterise/made_sensor.hpp"
#include "events/aedat4_bytes.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/characterise/physics_file.hpp"
#include "tactile/characterise/sensor_json.hpp"

namespace tactile::characterise {
namespace {

using Kind = UnusualPixel::Kind;

Sensor sensor_of(const test::MadeSensor& made, std::uint64_t seed) {
  const test::TemporaryFolder folder;
  return characterise({test::write_recording(folder / "quiet.aedat4", made.size, events_of(made, seed))}, {});
}

test::MadeSensor with_hot_pixels() {
  test::MadeSensor made;
  for (int i = 0; i < 12; ++i) made.hot.push_back({6 * i + 2, 4 * i + 3, 80.0 * (i + 1)});
  made.hot.push_back({71, 55, 50'000});  // faster than any read-out
  for (int i = 0; i < 8; ++i) made.dead.emplace_back(9 * i + 1, 7 * i + 1);
  return made;
}

TEST(Characterise, FindsWhatASensorWasMadeOf) {
  const test::MadeSensor made = with_hot_pixels();
  const Sensor sensor = sensor_of(made, 1);
  EXPECT_EQ(sensor.size, made.size);
  EXPECT_NEAR(sensor.seconds, 10, 0.1);
  EXPECT_EQ(sensor.readout.scan, events::Scan::columns);
  EXPECT_NEAR(sensor.readout.period_us.value, made.period_us, 1e-4);
  EXPECT_NEAR(sensor.readout.step_us.value, made.step_us, 1e-3);
  EXPECT_EQ(sensor.unusual.hot.value, 12);
  EXPECT_EQ(sensor.unusual.stuck.value, 1);
  ASSERT_FALSE(sensor.unusual.pixels.empty());
  EXPECT_EQ(sensor.unusual.pixels.front().kind, Kind::stuck);
  EXPECT_EQ(sensor.unusual.pixels.front().x, 71);
  EXPECT_EQ(sensor.unusual.pixels.front().y, 55);
  EXPECT_EQ(sensor.dead.silent, 8U);
  EXPECT_LT(test::off_by(sensor.dead.count, 8), 2);
  auto dead = made.dead;
  std::sort(dead.begin(), dead.end(), [](auto a, auto b) { return a.second < b.second; });
  EXPECT_EQ(sensor.dead.places, dead);
  EXPECT_TRUE(sensor.flicker.lines.empty());
  EXPECT_EQ(sensor.shortest_interval_us->value, 195);
  EXPECT_LT(test::off_by(*sensor.refractory_us, 0), 2) << "at most a read-out";
  EXPECT_EQ(sensor.largest.tick.value, 11) << "a stuck pixel fires at each of the read-outs in 2 ms";
  EXPECT_EQ(sensor.largest.history.value, 205);
  EXPECT_FALSE(sensor.background.is_disturbed());
}

TEST(Characterise, HasValuesWithinTheirUncertainty) {
  constexpr int seeds = 40;
  std::map<std::string, int> within;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    test::MadeSensor made;
    made.seconds = 6;
    const Sensor sensor = sensor_of(made, 100 + seed);
    const auto count = [&](const char* name, const Measured& measured, double truth) {
      within[name] += test::off_by(measured, truth) < 2;
    };
    count("on", sensor.background.on_hz, 1.2);
    count("off", sensor.background.off_hz, 0.8);
    count("spread", sensor.background.spread_decades, 0.2);
    count("regularity", sensor.background.regularity, 2);
    count("on spread", sensor.background.on_spread, 0);
    count("rate", sensor.rate_hz, 2.0 * 80 * 60);
    count("across", sensor.neighbours.horizontal, 0);
    count("down", sensor.neighbours.vertical, 0);
    count("period", sensor.readout.period_us, made.period_us);
    count("step", sensor.readout.step_us, made.step_us);
    count("dead", sensor.dead.count, 0);
    count("hot", sensor.unusual.hot, 0);
  }
  // Of normal errors 95.4 % are within two: fewer than 33 of 40 have a chance below 1 in 1000.
  for (const auto& [name, number] : within) EXPECT_GE(number, 33) << name;
}

TEST(Characterise, FindsFlicker) {
  test::MadeSensor made;
  made.shape = 1;
  made.background_hz = 5;
  made.flicker_hz = 100;
  made.flicker_depth = 0.3;
  const Sensor sensor = sensor_of(made, 3);
  ASSERT_EQ(sensor.flicker.lines.size(), 1U);
  EXPECT_NEAR(sensor.flicker.lines[0].hz.value, 100, 0.3);
  EXPECT_LT(test::off_by(sensor.flicker.lines[0].depth, 0.3), 3);
}

/// Three spots of 9 pixels each, in light that is pulsed: at each pulse a pixel fires ON and then OFF, or not at all.
std::vector<events::Event> with_strobes(const test::MadeSensor& made, std::vector<events::Event> events, double hz) {
  Random random(8);
  for (int pulse = 0; pulse < static_cast<int>(hz * made.seconds); ++pulse) {
    for (int pixel = 0; pixel < 27; ++pixel) {
      if (random.uniform() > 0.3) continue;
      for (const int on : {1, 0}) {
        const int x = 20 + 20 * (pixel / 9) + pixel % 3;
        const double t_us = 1e6 / hz * (pulse + (on == 1 ? 0 : 0.3)) + 200 * random.uniform(), offset = 1000 + made.step_us * x;
        const double stamp = offset + made.period_us * std::ceil((t_us - offset) / made.period_us);
        events.push_back(test::event(1'000'000 + std::llround(stamp), x, 2 + pixel % 9 / 3, on));
      }
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return events;
}

TEST(Characterise, FindsAStrobeInAPartOfTheImageAndTakesItsPixelsForNoneOfTheSensors) {
  const test::TemporaryFolder folder;
  test::MadeSensor made = with_hot_pixels();
  made.seconds = 4;
  for (const double hz : {250.0, 500.0}) {
    const auto file =
        test::write_recording(folder / fmt::format("{}.aedat4", hz), made.size, with_strobes(made, events_of(made, 12), hz));
    const Sensor sensor = characterise({file}, {});
    ASSERT_FALSE(sensor.flicker.lines.empty()) << hz;
    EXPECT_NEAR(sensor.flicker.lines[0].hz.value, hz, 0.1);
    EXPECT_EQ(sensor.flicker.lines[0].lit_pixels, 27U);
    EXPECT_TRUE(sensor.flicker.lines[0].is_local);
    EXPECT_GT(sensor.flicker.lines[0].depth.value, 0.9);
    EXPECT_EQ(sensor.unusual.lit, 27U);
    EXPECT_EQ(sensor.unusual.hot.value, 12) << "these fire by themselves";
    EXPECT_EQ(sensor.unusual.stuck.value, 1);
    EXPECT_EQ(sensor.unusual.warm.value, 0);
    EXPECT_EQ(physics_of(sensor).at("camera").at("hot_pixels"), 12);
    EXPECT_NEAR(sensor.background.on_hz.value, 1.2, 0.1);
  }
}

TEST(Characterise, FindsNoFlickerInTheRhythmsOfHotPixels) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made{.seconds = 4};
  std::vector<events::Event> events = events_of(made, 13);
  for (int pixel = 0; pixel < 6; ++pixel) {
    const double hz = 210 + 37 * pixel;
    for (int i = 0; i < static_cast<int>(hz * made.seconds); ++i)
      events.push_back(test::event(1'000'000 + std::llround(1e6 * i / hz), 10 + 10 * pixel, 20, 1));
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  const Sensor sensor = characterise({test::write_recording(folder / "a.aedat4", made.size, events)}, {});
  EXPECT_TRUE(sensor.flicker.lines.empty());
  EXPECT_EQ(sensor.unusual.hot.value, 6);
  EXPECT_EQ(sensor.unusual.lit, 0U);
}

/// Between `begin_us` and `end_us` an edge of 10 pixels stands and trembles 82 times a second.
std::vector<events::Event> with_motion(std::vector<events::Event> events, std::int64_t begin_us, std::int64_t end_us) {
  Random random(9);
  for (std::int64_t t_us = begin_us; t_us < end_us; t_us += 1'000'000 / 82) {
    for (int y = 20; y < 30; ++y) {
      for (int i = 0; i < 4; ++i)
        events.push_back(test::event(1'000'000 + t_us + static_cast<std::int64_t>(2'000 * random.uniform()), 40, y, i % 2));
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return events;
}

TEST(Characterise, UsesTheTimesInWhichNothingMoves) {
  const test::TemporaryFolder folder;
  test::MadeSensor made = with_hot_pixels();
  made.seconds = 8;
  const auto events = with_motion(with_motion(events_of(made, 14), 1'500'000, 3'500'000), 5'000'000, 6'000'000);
  const Sensor sensor = characterise({test::write_recording(folder / "a.aedat4", made.size, events)}, {});
  EXPECT_NEAR(sensor.seconds, 8 - 3 - 4 * 0.1, 0.1) << "0.1 s before and after each motion are left out too";
  EXPECT_NEAR(sensor.seconds + sensor.seconds_left_out, 8, 0.01);
  EXPECT_TRUE(sensor.flicker.lines.empty());
  EXPECT_EQ(sensor.unusual.hot.value, 12);
  EXPECT_EQ(sensor.unusual.warm.value, 0);
  EXPECT_FALSE(sensor.background.is_disturbed());
  EXPECT_LT(test::off_by(sensor.background.on_hz, 1.2), 3);
  EXPECT_NEAR(sensor.readout.period_us.value, made.period_us, 1e-3);
}

TEST(Characterise, RefusesARecordingInWhichSomethingMovesTooOften) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made{.seconds = 6};
  std::vector<events::Event> events = events_of(made, 15);
  for (std::int64_t i = 0; i < 10; ++i) events = with_motion(std::move(events), 600'000 * i, 600'000 * i + 200'000);
  const auto file = test::write_recording(folder / "a.aedat4", made.size, events);
  EXPECT_NE(test::error_of([&] {
              characterise({file}, {});
            }).find("a.aedat4: something moves all the time; expected 0.5 s or more without touch and motion"),
            std::string::npos);
}

TEST(Characterise, RefusesARecordingInWhichEdgesMoveSteadily) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made{.seconds = 1};
  const auto file = test::write_recording(folder / "a.aedat4", made.size, with_edges(made, events_of(made, 16)));
  EXPECT_NE(test::error_of([&] { characterise({file}, {}); }).find("a.aedat4: something moves all the time"), std::string::npos);
}

TEST(Characterise, FindsTheFrequencyOfSlowPulses) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made{.seconds = 4};
  const auto file = test::write_recording(folder / "a.aedat4", made.size, with_pulses(made, events_of(made, 17), 30));
  const std::vector<FlickerSeries> series = series_of(characterise({file}, {}).flicker);
  ASSERT_FALSE(series.empty());
  EXPECT_NEAR(series[0].line.hz.value, 30, 0.05);
  EXPECT_GT(series[0].multiples, 10U);
}

TEST(Characterise, ListsNoDeadPixelsThatItDoesNotKnow) {
  const test::TemporaryFolder folder;
  test::MadeSensor made{.seconds = 2, .background_hz = 1, .shape = 1};
  for (int i = 0; i < 2'400; ++i) made.dead.emplace_back(i % 80, 2 * (i / 80));
  // Something moves: each event comes with three more.
  std::vector<events::Event> events;
  for (events::Event event : events_of(made, 4)) {
    for (int k = 0; k < 4; ++k) {
      events.push_back(event);
      event.t = after(event.t, 1ms);
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  const Sensor sensor = characterise({test::write_recording(folder / "a.aedat4", made.size, events)}, {});
  ASSERT_TRUE(sensor.background.is_disturbed()) << sensor.background.regularity.value;
  ASSERT_GT(sensor.dead.expected, 0.5);
  ASSERT_GT(static_cast<double>(sensor.dead.silent), 2 * sensor.dead.expected);
  EXPECT_FALSE(sensor.dead.is_known());
  EXPECT_TRUE(sensor.dead.places.empty());
}

TEST(Characterise, CombinesRecordings) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made = with_hot_pixels();
  std::vector<events::Event> events = events_of(made, 5);
  const auto half =
      std::partition_point(events.begin(), events.end(), [](const auto& e) { return e.t < camera_time(6'000'000); });
  const auto whole = test::write_recording(folder / "whole.aedat4", made.size, events);
  const auto first = test::write_recording(folder / "first.aedat4", made.size, {events.begin(), half});
  const auto second = test::write_recording(folder / "second.aedat4", made.size, {half, events.end()});
  const Sensor together = characterise({first, second}, {}), one = characterise({whole}, {});
  EXPECT_EQ(together.events, one.events);
  EXPECT_EQ(together.unusual.hot.value, one.unusual.hot.value);
  EXPECT_NEAR(together.seconds, one.seconds, 0.001);
  EXPECT_NEAR(together.background.on_hz.value, one.background.on_hz.value, one.background.on_hz.uncertainty);
  EXPECT_NEAR(together.readout.period_us.value, one.readout.period_us.value, 3 * together.readout.period_us.uncertainty);
}

TEST(Characterise, TakesPassagesFromTouchedRecordings) {
  const test::TemporaryFolder folder;
  test::MadeSensor made;
  made.seconds = 2;
  made.background_hz = 0.3;
  std::vector<events::Event> touched;
  for (std::int64_t x = 0; x < 80; ++x) {
    for (std::int64_t i = 0; i < 4; ++i) {
      for (int y = 0; y < 60; ++y) touched.push_back(test::event(20'000 * x + 2'000 * i, static_cast<int>(x), y, 1));
    }
  }
  const Sensor sensor = characterise({test::write_recording(folder / "quiet.aedat4", made.size, events_of(made, 6))},
                                     {test::write_recording(folder / "touched.aedat4", made.size, touched)});
  ASSERT_TRUE(sensor.passages);
  EXPECT_NEAR(sensor.passages->on.value, 4, 0.05);
  EXPECT_EQ(sensor.dead.silent, 0U) << "a pixel that a marker moves over is not dead";
  EXPECT_EQ(sensor.dead.expected, 0) << "each pixel has fired when touched";
}

TEST(Characterise, RefusesWhatItCannotUse) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made{.seconds = 0.6};
  const auto file = test::write_recording(folder / "a.aedat4", made.size, events_of(made, 1));
  const auto brief = test::write_recording(folder / "brief.aedat4", made.size, test::events_of({.seconds = 0.2}, 1));
  EXPECT_NE(test::error_of([&] {
              characterise({brief}, {});
            }).find("brief.aedat4: lasts 0.2 s; expected 0.5 s or more without touch and motion"),
            std::string::npos);
  const auto other = test::write_recording(folder / "b.aedat4", {81, 60}, {test::event(1, 80, 1, 1), test::event(9, 1, 1, 1)});
  EXPECT_NE(test::error_of([&] {
              characterise({file, other}, {});
            }).find("b.aedat4: its sensor has 81x60 pixels; expected 80x60"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] { characterise({file}, {other}); }).find("b.aedat4: its sensor has 81x60"), std::string::npos);
  const auto empty = test::write_recording(folder / "empty.aedat4", made.size, {});
  EXPECT_NE(test::error_of([&] { characterise({empty}, {}); }).find("empty.aedat4: holds no event"), std::string::npos);
  const auto moment = test::write_recording(folder / "moment.aedat4", made.size, {test::event(5, 1, 1, 1)});
  EXPECT_NE(test::error_of([&] { characterise({moment}, {}); }).find("all events have the same time"), std::string::npos);
  const auto huge =
      test::write_bytes(folder / "huge.aedat4", test::file_start(0, test::xml_of(test::event_node(0, 32'767, 32'767, "A"))) +
                                                    test::packet(0, test::event_payload({test::event(1, 2, 3, 1)})));
  EXPECT_NE(test::error_of([&] { characterise({huge}, {}); }).find("expected at most 4194304 pixels"), std::string::npos);
}

TEST(Characterise, GivesTheSameForAnyNumberOfThreads) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made = with_hot_pixels();
  const auto file = test::write_recording(folder / "a.aedat4", made.size, events_of(made, 9));
  EXPECT_EQ(json_of(characterise({file}, {}, {.threads = 1})), json_of(characterise({file}, {}, {.threads = 4})));
}

TEST(PhysicsOf, HasTheMeasuredValues) {
  const Sensor sensor = sensor_of(with_hot_pixels(), 11);
  const nlohmann::json physics = physics_of(sensor);
  const nlohmann::json& camera = physics.at("camera");
  EXPECT_EQ(camera.at("size"), nlohmann::json({80, 60}));
  EXPECT_NEAR(camera.at("readout_us"), 195.163, 1e-3);
  EXPECT_NEAR(camera.at("scan_us_per_column"), 2.2, 1e-3) << "above 0 from high x to low x";
  EXPECT_EQ(camera.at("scan_us_per_row"), 0);
  EXPECT_NEAR(camera.at("background_hz"), 2, 0.1);
  EXPECT_NEAR(camera.at("background_on_share"), 0.6, 0.02);
  EXPECT_EQ(camera.at("hot_pixels"), 12);
  EXPECT_EQ(camera.at("hot_hz").size(), 12U);
  EXPECT_EQ(camera.at("stuck_pixels"), 1);
  EXPECT_LT(camera.at("refractory_us"), 195);
  EXPECT_FALSE(physics.at("sessions").at("vary"));
}

}  // namespace
}  // namespace tactile::characterise
