#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>

#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/run_folder.hpp"
#include "windows/made_runs.hpp"

namespace tactile {
namespace {

using test::run_tactile;

const std::string recordings = std::string("'") + TACTILE_TEST_DATA + "/aedat4/";

TEST(ViewCommand, DrawsRecordingsOfAnySensor) {
  const test::TemporaryFolder folder;
  for (const std::string name : {"dv-none", "dv-lz4", "dv-zstd-high", "dv-events-only"}) {
    const auto result = run_tactile("view " + recordings + name + ".aedat4' --th 10 --out sheet.png --json", folder.path());
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto json = nlohmann::json::parse(result.out);
    const int width = json.at("sensor").at("width");
    EXPECT_EQ(json.at("heatmap").at("width"), width / 5);
    for (const auto& tile : json.at("tiles")) {
      EXPECT_GT(tile.at("events"), 1000);
      EXPECT_EQ(tile.at("t_us").get<std::int64_t>() % 2000, 0);
      EXPECT_TRUE(tile.at("label").is_null());
    }
    EXPECT_FALSE(cv::imread((folder / "sheet.png").string()).empty());
  }
}

TEST(ViewCommand, CountsTheEventsOfEachWindow) {
  const test::TemporaryFolder folder;
  const test::LabelledRun run{.labelled = false};
  test::make_run(folder / "data", run);
  const auto result = run_tactile("view data/fan/01/events.aedat4 --th 40 --tiles 7 --out sheet.png --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto tiles = nlohmann::json::parse(result.out).at("tiles");
  ASSERT_EQ(tiles.size(), 7U);
  EXPECT_EQ(nlohmann::json::parse(result.out).at("simulated"), read_run_info(run_folder_at(folder / "data/fan/01")).simulated);
  const auto events = test::random_events(run);
  for (const auto& tile : tiles) {
    const CameraTime t = camera_time(tile.at("t_us"));
    EXPECT_EQ(tile.at("events"), std::count_if(events.begin(), events.end(),
                                               [&](const Event& event) { return event.t >= t - 40ms && event.t < t; }));
    EXPECT_NEAR(tile.at("since_first_event_ms"), static_cast<double>((t - events.front().t).count()) / 1000, 1e-9);
  }
}

TEST(ViewCommand, ShowsALabelledRunAroundItsOnsets) {
  const test::TemporaryFolder folder;
  test::make_run(folder / "data", {});
  const auto result = run_tactile("view data/fan/01 --out sheet.png --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::vector<std::string> labels;
  const auto json = nlohmann::json::parse(result.out);
  for (const auto& tile : json.at("tiles")) labels.push_back(tile.at("label"));
  EXPECT_EQ(labels, (std::vector<std::string>{"none", "press", "press", "none", "none", "none", "none", "slip", "slip", "slip",
                                              "slip", "none"}));
  const auto spaced = run_tactile("view data/fan/01 --tiles 5 --out spaced.png", folder.path());
  EXPECT_EQ(spaced.exit_code, 1);
  EXPECT_NE(spaced.err.find("--tiles: data/fan/01 is labelled"), std::string::npos) << spaced.err;
}

TEST(ViewCommand, RefusesInWordsWhatHasNoHeatmap) {
  const test::TemporaryFolder folder;
  const auto too_short = run_tactile("view " + recordings + "dv-lz4.aedat4' --th 40 --out sheet.png", folder.path());
  EXPECT_EQ(too_short.exit_code, 1);
  EXPECT_NE(too_short.err.find("no full history of 40 ms"), std::string::npos) << too_short.err;
  EXPECT_EQ(run_tactile("view " + recordings + "dv-lz4.aedat4' --th 10 --stream 99 --out sheet.png", folder.path()).exit_code, 1);
  EXPECT_EQ(run_tactile("view " + recordings + "truth.json' --out sheet.png", folder.path()).exit_code, 1);
  EXPECT_GE(run_tactile("view nowhere --out sheet.png", folder.path()).exit_code, 100);
  EXPECT_FALSE(std::filesystem::exists(folder / "sheet.png"));
}

}  // namespace
}  // namespace tactile
