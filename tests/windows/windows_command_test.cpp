#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "support/kill_moments.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/windows/dataset.hpp"
#include "windows/made_runs.hpp"

namespace tactile::windows {
namespace {

using test::run_tactile;

class WindowsCommand : public testing::Test {
 protected:
  void SetUp() override { test::make_three_runs(folder.path() / "data"); }
  test::TemporaryFolder folder;
};

TEST_F(WindowsCommand, ReadsDataAndWritesTheDatasetIntoIt) {
  const auto result = run_tactile("windows", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("usb-hub     1    30     30    30"), std::string::npos) << result.out;
  const auto verbose = run_tactile("windows --verbose", folder.path());
  EXPECT_NE(verbose.out.find("usb-hub/01    30     30    30"), std::string::npos) << verbose.out;
  EXPECT_NE(result.out.find("data/dataset.h5: written, 270 samples"), std::string::npos) << result.out;
  EXPECT_EQ(Dataset(folder / "data/dataset.h5").samples().size(), 270U);
  EXPECT_NE(run_tactile("windows", folder.path()).out.find("unchanged"), std::string::npos);
  EXPECT_NE(run_tactile("windows --seed 2", folder.path()).out.find("replaced"), std::string::npos);
}

TEST_F(WindowsCommand, PrintsTheSameAsJson) {
  const auto result = run_tactile("windows data --out elsewhere/set.h5 --window-ms 40 --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("outcome"), "written");
  EXPECT_EQ(json.at("samples"), 180);
  EXPECT_EQ(json.at("runs").at(2).at("object"), "usb-hub");
  EXPECT_EQ(json.at("runs").at(2).at("slip"), 20);
  const Dataset dataset(folder / "elsewhere/set.h5");
  EXPECT_EQ(json.at("manifest_sha256"), dataset.manifest_hash());
  EXPECT_EQ(dataset.run_folder(0), std::filesystem::canonical(folder / "data/fan/01"));
  EXPECT_TRUE(std::filesystem::exists(folder / "elsewhere/set.events.h5"));
}

TEST_F(WindowsCommand, EndsWithTwoWhereVerifyingFails) {
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  const auto good = run_tactile("windows --verify", folder.path());
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  labels::write_labels(folder / "data/fan/02/labels.json", test::labels_of({.begin_us = -700'100}));
  const auto bad = run_tactile("windows --verify", folder.path());
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_NE(bad.out.find("fan/02: labels.json has changed"), std::string::npos) << bad.out;
  const auto json = nlohmann::json::parse(run_tactile("windows --verify --json", folder.path()).out);
  EXPECT_EQ(json.at("verified"), false);
  EXPECT_FALSE(json.at("differences").empty());
}

TEST_F(WindowsCommand, KilledWhileItReplacesADatasetLeavesTheOldOneOrTheNewOne) {
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  const auto end = std::chrono::steady_clock::now();
  test::KillMoments moments(end - begin, static_cast<std::uint64_t>(end.time_since_epoch().count()));
  int killed = 0;
  for (int i = 0; i < 15; ++i) {
    {
      test::RunningCommand command("windows --seed " + std::to_string(i), folder.path());
      moments.sleep(0, 1);
      command.has_ended() ? moments.were_too_late() : void(++killed);
    }  // SIGKILL
    const Dataset dataset(folder / "data/dataset.h5");
    EXPECT_EQ(dataset.samples().size(), 270U);
    for (std::uint32_t index = 0; index < dataset.runs().size(); ++index)
      EXPECT_EQ(dataset.events(index).size(), dataset.runs()[index].events);
  }
  EXPECT_GT(killed, 2);
  EXPECT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  EXPECT_EQ(run_tactile("windows --verify", folder.path()).exit_code, 0);
}

TEST_F(WindowsCommand, NamesMisnamedRunsAndEndsWithOneWhereARunCannotBeRead) {
  std::filesystem::rename(folder / "data/usb-hub", folder / "data/USB_Hub");
  const auto misnamed = run_tactile("windows --json", folder.path());
  EXPECT_EQ(misnamed.exit_code, 0) << misnamed.err;
  EXPECT_NE(misnamed.err.find("data/USB_Hub: its run is left out"), std::string::npos) << misnamed.err;
  const nlohmann::json json = nlohmann::json::parse(misnamed.out);
  ASSERT_EQ(json.at("misnamed").size(), 1U);
  EXPECT_NE(json.at("misnamed").at(0).get<std::string>().find("rename it to usb-hub"), std::string::npos);
  EXPECT_EQ(json.at("warnings").at(0), json.at("misnamed").at(0));
  write_whole(folder / "data/fan/02/run.json", "null");
  const auto broken = run_tactile("windows --json", folder.path());
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_EQ(broken.err.find("json.exception"), std::string::npos) << broken.err;
  EXPECT_NE(
      broken.err.find("tactile: data/fan/02/run.json: is null; expected an object with the run's members; fan/02 is left out"),
      std::string::npos)
      << broken.err;
  EXPECT_EQ(nlohmann::json::parse(broken.out).at("errors").size(), 1U);
  EXPECT_EQ(Dataset(folder / "data/dataset.h5").runs().size(), 1U);
}

TEST_F(WindowsCommand, NamesRunsWithoutARecording) {
  std::filesystem::create_directories(folder / "data/fan/07");
  const auto result = run_tactile("windows", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("left out, because events.aedat4 is missing: data/fan/07\n"), std::string::npos) << result.err;
}

TEST_F(WindowsCommand, SaysOnceHowToLiftTheFlagsOfRunsThatAreUsedInPart) {
  const test::LabelledRun flagged{.run = "03",
                                  .intervals = {{Touch::press, camera_time(200'000), camera_time(260'000)},
                                                {Touch::slip, camera_time(500'000), camera_time(600'000)},
                                                {Touch::slip, camera_time(900'000), camera_time(1'000'000)}},
                                  .flags = {{.interval_index = 1, .reason = "look"}}};
  for (const char* run : {"03", "04"}) {
    test::LabelledRun one = flagged;
    one.run = run;
    one.seed = 10U + static_cast<std::uint64_t>(run[1]);
    test::make_run(folder / "data", one);
  }
  const auto result = run_tactile("windows", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string how =
      "Look at it with 'tactile view data/fan/03'. If a flagged label is right, confirm it by 'tactile label "
      "--confirm data/fan/03'";
  EXPECT_NE(result.err.find("fan/03: flagged and left out: slip-1. " + how), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("fan/04: flagged and left out: slip-1\n"), std::string::npos) << result.err;
}

TEST_F(WindowsCommand, NamesTheFolderOfAnObjectThatIsGivenForAllRuns) {
  const auto result = run_tactile("windows data/fan", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err, "tactile: data/fan: is the folder of one object's runs; expected the folder above it, DATA\n");
}

TEST_F(WindowsCommand, PrintsJsonOfANameThatIsNoUtf8) {
  const auto result = run_tactile("windows --json --out \"$(printf 'caf\\351').h5\"", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("dataset"), "caf\xEF\xBF\xBD.h5");
}

TEST_F(WindowsCommand, RefusesOptionsOutOfRange) {
  EXPECT_GE(run_tactile("windows --window-ms 0", folder.path()).exit_code, 100);
  EXPECT_GE(run_tactile("windows --tick-us 0", folder.path()).exit_code, 100);
  EXPECT_EQ(run_tactile("windows --history-ms 51", folder.path()).exit_code, 1);
  EXPECT_EQ(run_tactile("windows nowhere", folder.path()).exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(folder / "data/dataset.h5"));
}

}  // namespace
}  // namespace tactile::windows
