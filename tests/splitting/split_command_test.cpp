#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "events/recording_contents.hpp"
#include "splitting/long_recording.hpp"
#include "support/folder_image.hpp"
#include "support/kill_moments.hpp"
#include "support/paths.hpp"
#include "support/real_recordings.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::splitting {
namespace {
namespace fs = std::filesystem;

/// Three simulated runs in one recording, with at least 2.6 s of rest before each. Made once.
class SplitCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    made_folder = std::make_unique<test::TemporaryFolder>();
    write_whole(*made_folder / "rest.json", R"({"presets": {"tiny": {"timings": {"quiet_s": [2.6, 3.2]}}}})");
    const auto simulated =
        test::run_tactile("simulate sim --preset tiny --objects fan --runs 3 --physics rest.json", made_folder->path());
    ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
    made = test::join_runs(find_runs(*made_folder / "sim"), *made_folder / "take");
  }
  static void TearDownTestSuite() { made_folder.reset(); }

  SplitCommand() {
    fs::create_directory(folder / "take");
    for (const char* name : {"events.aedat4", "robot.csv"}) fs::create_hard_link(made.folder / name, folder / "take" / name);
  }
  test::CommandResult run(const std::string& arguments) const { return test::run_tactile(arguments, folder.path()); }
  nlohmann::json json_of(const std::string& arguments) const {
    const test::CommandResult result = run(arguments + " --json");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  }
  std::vector<RunFolder> find_runs_if_there() const {
    return fs::exists(folder / "data") ? find_runs(folder / "data") : std::vector<RunFolder>();
  }
  fs::path piece(const std::string& name) const { return folder / ("data/" + name + "/events.aedat4"); }

  static inline std::unique_ptr<test::TemporaryFolder> made_folder;
  static inline test::LongRecording made;
  test::TemporaryFolder folder;
};

TEST_F(SplitCommand, ProposesTheRunsThatWereJoinedWithTheirPressesAndSlips) {
  const nlohmann::json json = json_of("split take --dry-run");
  const nlohmann::json& runs = json.at("proposal").at("runs");
  ASSERT_EQ(runs.size(), 3U);
  EXPECT_TRUE(json.at("result").is_null());
  EXPECT_FALSE(fs::exists(folder / "data"));
  std::size_t next = 0;
  for (const nlohmann::json& proposed : runs) {
    EXPECT_EQ(proposed.at("presses"), 1) << proposed;
    EXPECT_EQ(proposed.at("slips"), 1) << proposed;
    for (const nlohmann::json& touch : proposed.at("touches")) {
      if (touch.at("kind") != "press" && touch.at("kind") != "slip") continue;
      const TouchInterval& truth = made.touches.at(next++);
      EXPECT_EQ(touch.at("kind"), name_of(truth.touch));
      EXPECT_NEAR(touch.at("begin_us").get<double>(), static_cast<double>(us_of(truth.start)), 30e3);
    }
  }
  // Each cut lies in the rest before a run, half-way between two touches.
  for (std::size_t i = 1; i < 3; ++i) {
    const std::int64_t cut = runs[i].at("begin_us");
    EXPECT_GT(cut, us_of(made.touches[2 * i - 1].end));
    EXPECT_LT(cut, us_of(made.touches[2 * i].start));
    EXPECT_EQ(runs[i].at("begin_us"), runs[i - 1].at("end_us"));
    EXPECT_GT(runs[i].at("quiet_before_s").get<double>(), 2.6);
  }
}

TEST_F(SplitCommand, CutsNoRunInItsHoldThoughNothingMovesForLong) {
  write_whole(folder / "hold.json", R"({"presets": {"tiny": {"timings": {"quiet_s": [2.6, 3.2], "hold_s": [2.2, 2.6]}}}})");
  ASSERT_EQ(run("simulate sim --preset tiny --objects fan --runs 3 --seed 4 --physics hold.json").exit_code, 0);
  const test::LongRecording held = test::join_runs(find_runs(folder / "sim"), folder / "held");
  ASSERT_EQ(run("convert held/events.aedat4 held.csv").exit_code, 0);
  for (const char* recording : {"held", "held.csv"}) {  // with robot log and IMU, and without both
    const nlohmann::json proposal = json_of(std::string("split --dry-run ") + recording).at("proposal");
    ASSERT_EQ(proposal.at("runs").size(), 3U) << recording << proposal;
    for (std::size_t i = 0; i < held.touches.size(); ++i) {
      const nlohmann::json& touches = proposal.at("runs").at(i / 2).at("touches");
      EXPECT_TRUE(std::any_of(touches.begin(), touches.end(),
                              [&](const nlohmann::json& touch) {
                                return touch.at("begin_us") < us_of(held.touches[i].end) &&
                                       touch.at("end_us") > us_of(held.touches[i].start);
                              }))
          << recording << i;
    }
  }
}

TEST_F(SplitCommand, GivesPiecesThatAreTheRecordingElementByElement) {
  const std::string before = test::hash_of(test::image_of(folder / "take"));
  const nlohmann::json json = json_of("split take --object fan");
  EXPECT_EQ(test::hash_of(test::image_of(folder / "take")), before);
  test::RecordingContents joined;
  for (const nlohmann::json& made_run : json.at("result").at("runs")) {
    const RunFolder run_made = run_folder_at(folder / made_run.at("folder").get<std::string>());
    const test::RecordingContents part = test::contents_of(run_made.events());
    EXPECT_EQ(made_run.at("events"), part.events.size());
    joined.events.insert(joined.events.end(), part.events.begin(), part.events.end());
    joined.imu.insert(joined.imu.end(), part.imu.begin(), part.imu.end());
    const RunInfo info = read_run_info(run_made);
    EXPECT_EQ(info.object, "fan");
    EXPECT_TRUE(info.simulated);
    EXPECT_TRUE(info.complete);
    EXPECT_EQ(json.at("result").at("session"), info.session);
    EXPECT_EQ(info.extra.at("split").at("sha256"), sha256_of_file(folder / "take/events.aedat4"));
    EXPECT_TRUE(check_files(run_made, info, FileComparison::contents).changed.empty());
  }
  EXPECT_TRUE(same(joined, test::contents_of(folder / "take/events.aedat4")));
  EXPECT_EQ(run("info --check data").exit_code, 0);
}

/// The onsets that `label` finds, with their 95 % intervals, by time.
std::vector<nlohmann::json> onsets_in(const test::CommandResult& labelled) {
  std::vector<nlohmann::json> onsets;
  const nlohmann::json json = nlohmann::json::parse(labelled.out);
  for (const nlohmann::json& run : json.at("runs"))
    for (const nlohmann::json& interval : run.at("intervals")) onsets.push_back(interval);
  std::sort(onsets.begin(), onsets.end(), [](const auto& a, const auto& b) { return a.at("start_us") < b.at("start_us"); });
  return onsets;
}

TEST_F(SplitCommand, LetsLabelFindInThePiecesWhatItFindsInTheWhole) {
  fs::create_directories(folder / "whole/fan");
  fs::rename(folder / "take", folder / "whole/fan/01");
  const test::CommandResult whole = run("label whole --no-pictures --json");
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  fs::remove(folder / "whole/fan/01/labels.json");  // else it would give the clock of the log
  const nlohmann::json split = json_of("split whole/fan/01 --object fan");
  EXPECT_NE(split.at("result").at("robot").get<std::string>().find("motions in log and recording"), std::string::npos);
  for (const nlohmann::json& made_run : split.at("result").at("runs")) EXPECT_LT(made_run.at("robot_rows"), 1'500);
  const test::CommandResult pieces = run("label data --no-pictures --json");
  ASSERT_EQ(pieces.exit_code, 0) << pieces.err;
  const std::vector<nlohmann::json> expected = onsets_in(whole), found = onsets_in(pieces);
  ASSERT_EQ(found.size(), made.touches.size()) << pieces.out;
  ASSERT_EQ(expected.size(), made.touches.size()) << whole.out;
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].at("class"), expected[i].at("class"));
    EXPECT_LE(found[i].at("start_low_us"), expected[i].at("start_high_us"));
    EXPECT_GE(found[i].at("start_high_us"), expected[i].at("start_low_us"));
    EXPECT_NEAR(found[i].at("start_us").get<double>(), static_cast<double>(us_of(made.touches[i].start)), 20e3);
  }
}

TEST_F(SplitCommand, KeepsRunsThatItMadeAndRefusesToCutTheSameEventsTwice) {
  ASSERT_EQ(run("split take --object fan").exit_code, 0);
  const std::string before = test::hash_of(test::image_of(folder / "data"));
  const nlohmann::json again = json_of("split take --object fan");
  for (const nlohmann::json& made_run : again.at("result").at("runs")) EXPECT_TRUE(made_run.at("kept"));
  for (const char* other : {"split take --object fan --at 3", "split take --object usb-hub"}) {
    const test::CommandResult refused = run(other);
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_NE(refused.err.find("fan/01, fan/02, fan/03 were made from this recording before"), std::string::npos) << refused.err;
  }
  EXPECT_EQ(test::hash_of(test::image_of(folder / "data")), before);
  // A run that was removed is made again.
  fs::remove_all(folder / "data/fan/02");
  EXPECT_EQ(run("split take --object fan --first-run 02").exit_code, 0);
  EXPECT_TRUE(fs::exists(piece("fan/02")));
}

TEST_F(SplitCommand, TakesFreeNumbersAndOneObjectForEachRun) {
  fs::create_directories(folder / "data/fan/02");
  write_whole(folder / "data/fan/02/precious.txt", "precious");
  const nlohmann::json json = json_of("split take --at 2.5,5.25 --object fan,usb-hub,fan --first-run 01");
  const nlohmann::json& runs = json.at("result").at("runs");
  EXPECT_EQ(runs[0].at("run"), "fan/01");
  EXPECT_EQ(runs[1].at("run"), "usb-hub/01");
  EXPECT_EQ(runs[2].at("run"), "fan/03");
  EXPECT_EQ(read_text(folder / "data/fan/02/precious.txt"), "precious");
  EXPECT_TRUE(json.at("proposal").at("runs")[0].at("presses").is_null());
  const auto events = test::contents_of(piece("usb-hub/01")).events;
  const CameraTime first = test::contents_of(folder / "take/events.aedat4").events.front().t;
  EXPECT_GE(events.front().t, after(first, 2'500ms));
  EXPECT_LT(events.back().t, after(first, 5'250ms));

  const std::string cut = "split take --at 2.5,5.25 --dry-run";
  EXPECT_NE(run(cut).out.find(" 2.500 "), std::string::npos);
  const std::string camera = run(cut + " --camera-time").out;
  const double first_s = 1e-6 * static_cast<double>(us_of(first));
  EXPECT_NE(camera.find(fmt::format("{:.3f}", first_s + 2.5)), std::string::npos) << camera;
}

TEST_F(SplitCommand, CutsMorePiecesThanFilesMayBeOpenByDefault) {
  std::string split = " split take/events.aedat4 --object fan --at 0.05";
  for (int i = 2; i <= 60; ++i) split += fmt::format(",{:.2f}", 0.05 * i);
  const auto refused = test::run_shell("ulimit -n 80; '" + std::string(test::tactile_binary) + "'" + split, folder.path());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("61 pieces need 247 open files, and this system allows 80"), std::string::npos) << refused.err;
  EXPECT_TRUE(find_runs_if_there().empty());
  const auto cut = test::run_shell("ulimit -Sn 80; '" + std::string(test::tactile_binary) + "'" + split, folder.path());
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_EQ(find_runs_if_there().size(), 61U);
}

TEST_F(SplitCommand, GivesEveryRunTheWholeLogIfItsClockIsNotKnown) {
  // An arm that rests has no common motion with the recording.
  write_whole(folder / "rest.csv",
              "timestamp,actual_TCP_speed_0,actual_TCP_speed_1,actual_TCP_speed_2,actual_TCP_speed_3,actual_TCP_speed_4,"
              "actual_TCP_speed_5\n1.0,0,0,0,0,0,0\n1.008,0,0,0,0,0,0\n1.016,0,0,0,0,0,0\n");
  const test::CommandResult result = run("split take --robot rest.csv --object fan");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("each run has the whole log, because its clock is not known"), std::string::npos) << result.out;
  EXPECT_EQ(read_text(folder / "data/fan/03/robot.csv"), read_text(folder / "rest.csv"));
}

TEST_F(SplitCommand, ReportsInOneLineWhyItWritesNothing) {
  for (const char* arguments :
       {"take --at 3,2", "take --at 0", "take --at 1000", "take --object Fan", "take --object fan,usb-hub", "missing.aedat4",
        "take --first-run 98 --object fan", "take/robot.csv", "take --at 2,2.0000001"}) {
    const test::CommandResult result = run(std::string("split --quiet ") + arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments << result.out;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_TRUE(find_runs_if_there().empty()) << arguments;
  }
}

/// In the folder of runs, the recording itself would be used like its pieces.
TEST_F(SplitCommand, WarnsOfARecordingAmongItsOwnPieces) {
  fs::create_directories(folder / "data/fan");
  fs::rename(folder / "take", folder / "data/fan/01");
  const auto among = run("split data/fan/01 --at 1.2 --object mug");
  EXPECT_NE(among.err.find("fan/01 has the same events as its pieces: move it out of data before"), std::string::npos)
      << among.err;
  EXPECT_FALSE(json_of("split data/fan/01 --at 1.2 --object mug").at("result").at("warning").is_null());
  const auto apart = run("split data/fan/01 --at 1.2 --object mug --out other");
  EXPECT_EQ(apart.err.find("same events"), std::string::npos) << apart.err;
}

TEST_F(SplitCommand, CutsABagWithItsRobotLogAndFilm) {
  fs::copy_file(fs::path(test::data_folder) / "bags/run.bag", folder / "run.bag");
  const nlohmann::json json = json_of("split run.bag --at 0.05 --object mug");
  ASSERT_EQ(json.at("result").at("runs").size(), 2U);
  EXPECT_TRUE(fs::exists(folder / "data/mug/02/robot.csv"));
  EXPECT_TRUE(fs::exists(folder / "data/mug/02/video.mp4"));
  EXPECT_EQ(read_run_info(run_folder_at(folder / "data/mug/02")).extra.at("split").at("from"), "run.bag");
  EXPECT_EQ(run("info --check data").exit_code, 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "data"), {}), 1) << "what the conversion made is still there";
}

TEST_F(SplitCommand, CutsWhatConvertReads) {
  ASSERT_EQ(run("convert take/events.aedat4 take.csv").exit_code, 0);
  ASSERT_EQ(run("split take.csv --at 2 --object mug").exit_code, 0);
  auto joined = test::contents_of(piece("mug/01")).events;
  const auto second = test::contents_of(piece("mug/02")).events;
  joined.insert(joined.end(), second.begin(), second.end());
  EXPECT_EQ(joined, test::contents_of(folder / "take/events.aedat4").events);
}

TEST_F(SplitCommand, ProposesRealRecordingsSensibly) {
  // Short recordings of a sensor that moves all the time: nothing is quiet for long, so each is one run.
  for (const char* name : {"aermanager/dvxplorer_class2_data_sample.aedat4", "faery/davis346.aedat4"}) {
    const fs::path recording = test::real_recording(name);
    if (recording.empty()) GTEST_SKIP() << test::not_tested_without(name);
    const nlohmann::json json =
        json_of("split '" + recording.string() + "' --object mug --out " + fs::path(name).stem().string());
    EXPECT_EQ(json.at("proposal").at("runs").size(), 1U) << name;
    const fs::path whole = folder / (fs::path(name).stem().string() + "/mug/01/events.aedat4");
    EXPECT_TRUE(same(test::contents_of(whole), test::contents_of(recording))) << name;
  }
}

TEST_F(SplitCommand, LeavesWholeRunsOrNoneWhenItIsKilled) {
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(run("split take --object fan").exit_code, 0);
  test::KillMoments moments(std::chrono::steady_clock::now() - begin, 5);
  const std::string input = test::hash_of(test::image_of(folder / "take"));
  for (int i = 0; i < 8; ++i) {
    fs::remove_all(folder / "data");
    test::RunningCommand killed("split take --object fan", folder.path());
    moments.sleep(0.2, 1);
    if (killed.has_ended())
      moments.were_too_late();
    else
      killed.signal(SIGKILL);
    killed.wait();
    for (const RunFolder& whole : find_runs_if_there())
      EXPECT_TRUE(check_files(whole, read_run_info(whole), FileComparison::contents).changed.empty());
    EXPECT_EQ(test::hash_of(test::image_of(folder / "take")), input);
  }
  const test::CommandResult result = run("split take --object fan");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(find_runs(folder / "data").size(), 3U);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "data/fan"), {}), 3) << "what a killed call left is still there";
}

}  // namespace
}  // namespace tactile::splitting
