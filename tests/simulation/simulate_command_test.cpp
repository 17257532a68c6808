#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/run_command.hpp"
#include "tactile/core/command_lock.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::simulation {
namespace {

TEST(SimulateCommand, MakesARunAndPrintsIt) {
  const test::TemporaryFolder folder;
  const auto made = test::run_tactile("simulate runs --preset tiny --objects usb-hub --runs 1 --json", folder.path());
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto json = nlohmann::json::parse(made.out);
  EXPECT_EQ(json.at("made"), 1);
  EXPECT_EQ(json.at("runs").at(0).at("run"), "usb-hub/01");
  EXPECT_GT(json.at("runs").at(0).at("events").get<int>(), 10'000);
  EXPECT_EQ(find_runs(folder / "runs").size(), 1U);

  const auto kept = test::run_tactile("simulate runs --preset tiny --objects usb-hub --runs 1", folder.path());
  EXPECT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_NE(kept.out.find("0 made, 1 kept, 0 replaced, 0 removed"), std::string::npos) << kept.out;

  const auto refused = test::run_tactile("simulate runs --preset tiny --objects usb-hub --runs 1 --seed 2", folder.path());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("was simulated with preset tiny, seed 1; expected preset tiny, seed 2, or --force to replace it"),
            std::string::npos)
      << refused.err;
  const auto forced = test::run_tactile("simulate runs --preset tiny --objects usb-hub --runs 1 --seed 2 --force", folder.path());
  EXPECT_EQ(forced.exit_code, 0) << forced.err;
  EXPECT_NE(forced.out.find("0 made, 0 kept, 1 replaced, 0 removed"), std::string::npos) << forced.out;
}

TEST(SimulateCommand, EndsAtOnceWhereAnotherWritesTheSameFolder) {
  const test::TemporaryFolder folder;
  const std::string command = "simulate runs --preset tiny --objects usb-hub --runs 1";
  {
    const CommandLock another(folder / "runs", "tactile simulate", ".simulate.lock");
    for (const std::string options : {"", " --seed 2 --force"}) {
      const auto refused = test::run_tactile(command + options, folder.path());
      EXPECT_EQ(refused.exit_code, 1);
      EXPECT_EQ(refused.err,
                "tactile: runs: another 'tactile simulate' is writing to this folder; wait until it has ended, or use another "
                "folder\n");
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "runs/usb-hub"));
  }
  EXPECT_EQ(test::run_tactile(command, folder.path()).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "runs/.simulate.lock"));
}

TEST(SimulateCommand, TakesOtherPhysicsAndPrintsItsSpeed) {
  const test::TemporaryFolder folder;
  write_whole(folder / "cup.json", R"({"why": "A cup.", "objects": [{"name": "cup", "radius_mm": 40}]})");
  const auto made =
      test::run_tactile("simulate runs --physics cup.json --preset tiny --objects cup --runs 1 --json", folder.path());
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto json = nlohmann::json::parse(made.out);
  EXPECT_EQ(json.at("physics").get<std::string>(), "cup.json");
  EXPECT_EQ(json.at("runs").at(0).at("run").get<std::string>(), "cup/01");
  EXPECT_GT(json.at("times_real_time").get<double>(), 0.0);
  EXPECT_GT(json.at("touch_events_per_s").get<double>(), 1e4);
  const auto kept =
      test::run_tactile("simulate runs --physics cup.json --preset tiny --objects cup --runs 1 --json", folder.path());
  EXPECT_FALSE(nlohmann::json::parse(kept.out).contains("times_real_time")) << "nothing was made";
}

TEST(SimulateCommand, NamesTheNearestOfWhatThereIsNot) {
  const test::TemporaryFolder folder;
  write_whole(folder / "wrong.json", R"({"camera": {"treshold": 0.3}})");
  const std::vector<std::pair<std::string, std::string>> cases{
      {"--preset papr", "expected paper, quick or tiny"},
      {"--objects sprayr", "'sprayer'"},
      {"--objects fan,sprayr", "'sprayer'"},
      {"--physics wrong.json", "wrong.json: there is no 'camera.treshold'"},
      {"--physics none.json", "none.json"}};
  for (const auto& [options, named] : cases) {
    const auto result = test::run_tactile("simulate runs " + options, folder.path());
    EXPECT_NE(result.exit_code, 0) << options;
    EXPECT_NE(result.err.find(named), std::string::npos) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "runs")) << options;
  }
}

TEST(SimulateCommand, RefusesOptionsOutOfRange) {
  const test::TemporaryFolder folder;
  for (const std::string wrong : {"--preset huge", "--runs 0", "--runs 100", "--seed -1", "--objects cup"}) {
    const auto result = test::run_tactile("simulate runs " + wrong, folder.path());
    EXPECT_NE(result.exit_code, 0) << wrong;
    EXPECT_FALSE(result.err.empty()) << wrong;
    EXPECT_FALSE(std::filesystem::exists(folder / "runs")) << wrong;
  }
}

}  // namespace
}  // namespace tactile::simulation
