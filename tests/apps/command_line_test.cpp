#include <gtest/gtest.h>

#include <regex>

#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

using test::run_tactile;

const std::vector<std::string> commands{"simulate", "info", "repair", "convert", "label", "windows",
                                        "heatmaps", "view", "train",  "eval",    "doctor"};

TEST(CommandLine, VersionNamesTheGitRevision) {
  const auto result = run_tactile("--version");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(std::regex_search(result.out, std::regex(R"(^tactile \d+\.\d+\.\d+ \(.+\)\n$)"))) << result.out;
}

TEST(CommandLine, HelpListsEveryCommandInTheOrderOfUse) {
  const auto result = run_tactile("--help");
  EXPECT_EQ(result.exit_code, 0);
  std::size_t place = 0;
  for (const std::string& command : commands) {
    const std::size_t found = result.out.find("\n  " + command + " ", place);
    ASSERT_NE(found, std::string::npos) << command << " in\n" << result.out;
    place = found;
  }
}

TEST(CommandLine, EveryCommandHasHelpWithTheCommonOptions) {
  for (const std::string& command : commands) {
    const auto result = run_tactile(command + " --help");
    EXPECT_EQ(result.exit_code, 0) << command;
    for (const char* option : {"--config", "--json", "--quiet", "--threads"})
      EXPECT_NE(result.out.find(option), std::string::npos) << command << " " << option;
  }
}

TEST(CommandLine, UnknownOptionAndUnknownCommandAreUsageErrors) {
  for (const char* arguments : {"doctor --bogus", "bogus", ""}) {
    const auto result = run_tactile(arguments);
    EXPECT_GE(result.exit_code, 100) << arguments;
    EXPECT_TRUE(result.out.empty());
    EXPECT_FALSE(result.err.empty());
  }
}

TEST(CommandLine, ValueOutOfRangeIsRefusedWithTheRange) {
  const auto result = run_tactile("doctor --threads 0");
  EXPECT_GE(result.exit_code, 100);
  EXPECT_TRUE(std::regex_search(result.err, std::regex("1.*1024"))) << result.err;
}

TEST(CommandLine, MistypedCommandNamesTheNearest) {
  const auto result = run_tactile("simulat");
  EXPECT_GE(result.exit_code, 100);
  EXPECT_NE(result.err.find("'simulate'"), std::string::npos) << result.err;
}

TEST(CommandLine, SeedOutOfRangeAndNanAreRefused) {
  for (const char* arguments :
       {"windows --seed -1", "windows --seed 99999999999999999999", "simulate --seed -1", "windows --guard-ms nan"}) {
    const auto result = run_tactile(arguments);
    EXPECT_GE(result.exit_code, 100) << arguments;
    EXPECT_LT(result.err.size(), 200U) << result.err;
  }
}

TEST(CommandLine, ErrorIsOneLineThatNamesWhatIsWrong) {
  const auto result = run_tactile("label /no/such/folder");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_NE(result.err.find("/no/such/folder"), std::string::npos);
}

TEST(Config, KeyThatNoOptionHasNamesTheNearestOne) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", R"({"thread": 1})");
  const auto result = run_tactile("doctor --config config.json", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("'thread'"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("'threads'"), std::string::npos) << result.err;
}

TEST(Config, ValueIsCheckedAsOnTheCommandLine) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", R"({"threads": 0})");
  const auto result = run_tactile("doctor --config config.json", folder.path());
  EXPECT_GE(result.exit_code, 100);
  EXPECT_TRUE(std::regex_search(result.err, std::regex("1.*1024"))) << result.err;
}

TEST(Config, FillsInWhatTheCommandLineLeavesOpenAndNoMore) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", R"({"json": true, "threads": 0})");
  const auto result = run_tactile("doctor --threads 1 --config config.json", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.substr(0, 1), "{");
}

TEST(Config, PositionalAndListTakeTheirValuesToo) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", R"({"data": ["/no/such/folder"]})");
  const auto result = run_tactile("label --config config.json", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("/no/such/folder"), std::string::npos) << result.err;
}

TEST(Config, ThatIsNoJsonIsAnErrorThatNamesIt) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", "threads = 1");
  const auto result = run_tactile("doctor --config config.json", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("config.json"), std::string::npos) << result.err;
}

TEST(Config, FilesThatComeAlongAreTakenByTheirCommands) {
  const test::TemporaryFolder folder;
  for (const char* name : {"heatmaps-as-printed", "windows-as-paper", "train-thorough"}) {
    const std::string file = std::string(TACTILE_TEST_DATA) + "/../../configs/" + name + ".json";
    const std::string command(name, std::string(name).find('-'));
    const auto result = run_tactile(command + " --config '" + file + "'", folder.path());
    EXPECT_EQ(result.exit_code, 1) << "there is no data here";
    EXPECT_EQ(result.err.find(name), std::string::npos) << result.err;
  }
}

TEST(Config, GivesARequiredOptionToo) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", R"({"out": "sheet.png", "th": 10})");
  const auto result = run_tactile("view '" TACTILE_TEST_DATA "/aedat4/dv-lz4.aedat4' --config config.json", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "sheet.png"));
}

TEST(Doctor, SaysWhatMattersInJson) {
  const auto result = run_tactile("doctor --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* key : {"\"libtorch\"", "\"blas\"", "\"timer_step_ns\"", "\"disk_write_mb_per_s\"", "\"libcaer\""}) {
    EXPECT_NE(result.out.find(key), std::string::npos) << key;
  }
}

}  // namespace
}  // namespace tactile
