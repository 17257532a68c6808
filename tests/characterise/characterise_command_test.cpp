#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "characterise/made_sensor.hpp"
#include "support/real_recordings.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"

namespace tactile {
namespace {

test::MadeSensor made_sensor() {
  test::MadeSensor made{.seconds = 3};
  for (int i = 0; i < 5; ++i) made.hot.push_back({10 * i + 2, 8 * i + 3, 300});
  return made;
}

TEST(CharacteriseCommand, WritesWhatItMeasured) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made = made_sensor();
  test::write_recording(folder / "quiet.aedat4", made.size, events_of(made, 1));
  const test::CommandResult result = test::run_tactile("characterise quiet.aedat4 --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("unusual_pixels").at("hot").at("value"), 5);
  nlohmann::json file = read_json(folder / "sensor/sensor.json");
  file["out"] = "sensor";
  EXPECT_EQ(file, json);
  EXPECT_EQ(test::text_in_file(folder / "sensor/sensor.png").substr(1, 3), "PNG");
  const std::string mask = test::text_in_file(folder / "sensor/mask.csv");
  EXPECT_EQ(std::count(mask.begin(), mask.end(), '\n'), 6);
  EXPECT_EQ(mask.substr(0, mask.find('\n')), "x,y,kind,rate_hz");
  EXPECT_NE(mask.find("\n2,3,hot,"), std::string::npos) << mask;
  EXPECT_EQ(read_json(folder / "sensor/physics.json").at("camera").at("hot_pixels"), 5);
}

TEST(CharacteriseCommand, PrintsAReportForPeople) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made = made_sensor();
  test::write_recording(folder / "quiet.aedat4", made.size, events_of(made, 2));
  const test::CommandResult result = test::run_tactile("characterise quiet.aedat4 --out s", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* words :
       {"Made, 80 x 60 pixels", "every 195.16", "columns from right to left", "background", "flicker", "Written to s:"})
    EXPECT_NE(result.out.find(words), std::string::npos) << words << " in\n" << result.out;
}

TEST(CharacteriseCommand, ReplacesNothingWithoutForce) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made = made_sensor();
  test::write_recording(folder / "quiet.aedat4", made.size, events_of(made, 3));
  ASSERT_EQ(test::run_tactile("characterise quiet.aedat4", folder.path()).exit_code, 0);
  const test::CommandResult again = test::run_tactile("characterise quiet.aedat4", folder.path());
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_NE(again.err.find("sensor/sensor.json: exists already; expected another --out, or --force"), std::string::npos)
      << again.err;
  EXPECT_EQ(test::run_tactile("characterise quiet.aedat4 --force", folder.path()).exit_code, 0);
}

TEST(CharacteriseCommand, WritesNothingForAFileThatItCannotRead) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "text.aedat4") << "no recording";
  const test::CommandResult result = test::run_tactile("characterise text.aedat4", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("text.aedat4"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "sensor"));
}

/// Characterises a recording, simulates a run of two seconds with its physics, characterises this run, and compares both. The
/// lens of the simulated camera is capped, so that its noise is all it shows.
void expect_the_same_when_simulated(const std::filesystem::path& recording, std::vector<const char*> names) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(test::run_tactile("characterise " + recording.string() + " --out first", folder.path()).exit_code, 0);
  nlohmann::json physics = read_json(folder / "first/physics.json");
  for (const char* key : {"skin", "black", "white"}) physics["camera"][key] = 0;
  std::ofstream(folder / "capped.json") << physics;
  const test::CommandResult simulated =
      test::run_tactile("simulate data --physics capped.json --objects fan --preset quick --runs 1", folder.path());
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  ASSERT_EQ(test::run_tactile("convert data/fan/01 run.aedat4 --to-us +2000000", folder.path()).exit_code, 0);
  ASSERT_EQ(test::run_tactile("characterise run.aedat4 --out second", folder.path()).exit_code, 0);
  const nlohmann::json first = read_json(folder / "first/sensor.json"), second = read_json(folder / "second/sensor.json");
  for (const char* name : names) {
    const nlohmann::json &a = first.at(nlohmann::json::json_pointer(name)), &b = second.at(nlohmann::json::json_pointer(name));
    const double uncertainty = std::hypot(a.at("uncertainty").get<double>(), b.at("uncertainty").get<double>());
    EXPECT_NEAR(a.at("value").get<double>(), b.at("value").get<double>(), 3 * uncertainty + 1e-6) << name;
  }
}

TEST(CharacteriseCommand, FindsTheSameInRunsThatWereSimulatedWithItsPhysics) {
  const test::TemporaryFolder folder;
  const test::MadeSensor made{
      .size = {160, 120}, .seconds = 6, .step_us = -1.2, .background_hz = 0.8, .shape = 2, .hot = made_sensor().hot};
  const auto quiet = test::write_recording(folder / "quiet.aedat4", made.size, events_of(made, 4));
  expect_the_same_when_simulated(
      quiet, {"/readout/period_us", "/readout/us_per_line", "/background/on_hz", "/background/off_hz",
              "/background/spread_decades", "/background/regularity", "/unusual_pixels/hot", "/unusual_pixels/stuck",
              "/unusual_pixels/hot_share_of_events", "/refractory_us", "/dead_pixels/count"});
}

/// docs/cli/ names the values that differ.
TEST(CharacteriseCommand, FindsTheSameInRunsThatWereSimulatedAsARealSensor) {
  const char* const still = "derived/dvxplorer640_libcaer_rollover.aedat4";
  if (test::real_recording(still).empty()) GTEST_SKIP() << test::not_tested_without(still);
  expect_the_same_when_simulated(test::real_recording(still), {"/rate_hz",
                                                               "/rate_without_hot_hz",
                                                               "/readout/period_us",
                                                               "/readout/us_per_line",
                                                               "/readout/jitter_us",
                                                               "/readout/wander_us",
                                                               "/background/on_hz",
                                                               "/background/off_hz",
                                                               "/background/spread_decades",
                                                               "/background/regularity",
                                                               "/background/on_spread",
                                                               "/unusual_pixels/hot",
                                                               "/unusual_pixels/hot_share_of_events",
                                                               "/unusual_pixels/warm",
                                                               "/unusual_pixels/stuck",
                                                               "/unusual_pixels/on_share",
                                                               "/shortest_interval_us",
                                                               "/refractory_us",
                                                               "/dead_pixels/count",
                                                               "/largest_count/all/tick",
                                                               "/largest_count/all/history",
                                                               "/packets/interval_us",
                                                               "/packets/wait_us"});
}

}  // namespace
}  // namespace tactile
