#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using test::run_tactile;

class RepairCommand : public testing::Test {
 protected:
  RepairCommand() {
    fs::copy_file(std::string(test::data_folder) + "/aedat4/dv-lz4.aedat4", folder / "cut.aedat4");
    fs::resize_file(folder / "cut.aedat4", 40'000);
  }
  test::CommandResult run(const std::string& arguments) const { return run_tactile(arguments, folder.path()); }

  test::TemporaryFolder folder;
};

TEST_F(RepairCommand, MakesASickRecordingPassTheCheck) {
  EXPECT_EQ(run("info --check cut.aedat4").exit_code, 2);
  const test::CommandResult result = run("repair cut.aedat4 whole.aedat4");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("after the last whole packet"), std::string::npos) << result.out;
  const test::CommandResult check = run("info --check whole.aedat4");
  EXPECT_EQ(check.exit_code, 0) << check.err;
}

TEST_F(RepairCommand, AccountsForEveryByteAsJson) {
  const test::CommandResult result = run("repair --json cut.aedat4 whole.aedat4");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("bytes_in"), 40'000);
  EXPECT_EQ(json.at("bytes_out"), fs::file_size(folder / "whole.aedat4"));
  EXPECT_EQ(json.at("bytes_lost"), json.at("problems").at("truncated_bytes"));
  EXPECT_GT(json.at("bytes_lost"), 0);
  EXPECT_EQ(json.at("packets_lost"), 0);
  EXPECT_EQ(json.at("losses").size(), 1U);
  EXPECT_EQ(json.at("table_rebuilt"), true);
}

TEST_F(RepairCommand, MakesAWholeRunOfOneThatWasKilled) {
  ASSERT_EQ(run("simulate data --preset tiny --objects fan --runs 1").exit_code, 0);
  const fs::path events = folder / "data/fan/01/events.aedat4";
  fs::resize_file(events, fs::file_size(events) - 3'000);
  nlohmann::json info = nlohmann::json::parse(read_text(folder / "data/fan/01/run.json"));
  info["complete"] = false;
  info.erase("files");
  write_whole(folder / "data/fan/01/run.json", info.dump());
  EXPECT_EQ(run("info --check data/fan/01").exit_code, 2);

  const test::CommandResult result = run("repair data/fan/01 data/fan/02");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const test::CommandResult check = run("info --check data/fan/02");
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  const nlohmann::json repaired = nlohmann::json::parse(read_text(folder / "data/fan/02/run.json"));
  EXPECT_EQ(repaired.at("run"), "02");
  EXPECT_EQ(repaired.at("repaired").at("from"), "fan/01");
  EXPECT_EQ(read_text(folder / "data/fan/02/robot.csv"), read_text(folder / "data/fan/01/robot.csv"));
  EXPECT_EQ(run("label data/fan/02").exit_code, 0);

  EXPECT_EQ(run("repair data/fan/01 data/fan/02").exit_code, 1);
  EXPECT_EQ(run("repair data/fan/01 data/fan/second").exit_code, 1);
}

TEST_F(RepairCommand, CutsTheLogsOfARunAheadOfThePowerCutsZeros) {
  ASSERT_EQ(run("simulate data --preset tiny --objects fan --runs 1").exit_code, 0);
  const fs::path log = folder / "data/fan/01/robot.csv";
  const std::string rows = read_text(log);
  const std::size_t hole = rows.size() / 2, row_end = rows.rfind('\n', hole) + 1;
  write_whole(log, rows.substr(0, hole) + std::string(70'000, '\0') + rows.substr(hole));
  const test::CommandResult result = run("repair --json data/fan/01 data/fan/02");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read_text(folder / "data/fan/02/robot.csv"), rows.substr(0, row_end));
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("log_bytes_lost"), (nlohmann::json{{"robot.csv", 70'000 + rows.size() - row_end}}));
  EXPECT_NE(json.at("losses").dump().find("of robot.csv"), std::string::npos) << json.at("losses");
  EXPECT_EQ(run("info --check data/fan/02").exit_code, 0);
}

TEST_F(RepairCommand, ReportsInOneLineWhyItDoesNotWrite) {
  write_whole(folder / "there.aedat4", "precious");
  fs::create_hard_link(folder / "cut.aedat4", folder / "same.aedat4");
  for (const char* out : {"cut.aedat4", "./cut.aedat4", "same.aedat4", "there.aedat4", "whole.csv"}) {
    const test::CommandResult result = run(std::string("repair cut.aedat4 ") + out);
    EXPECT_EQ(result.exit_code, 1) << out;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
  EXPECT_EQ(run("repair --force cut.aedat4 same.aedat4").exit_code, 1);
  EXPECT_EQ(read_text(folder / "there.aedat4"), "precious");
  EXPECT_EQ(run("repair --force cut.aedat4 there.aedat4").exit_code, 0);
}

}  // namespace
}  // namespace tactile::cli
