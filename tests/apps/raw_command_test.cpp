#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "events/made_raw.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using test::run_tactile;

/// A RAW file of 20 000 events in 0.2 s, with 20 triggers.
class RawCommands : public testing::Test {
 protected:
  void SetUp() override { test::write_raw(folder / "a.raw", test::evt3_header, test::steady_evt3(20'000)); }

  nlohmann::json json_of(const std::string& command) const {
    const test::CommandResult result = run_tactile(command, folder.path());
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.err;
    return result.exit_code == 0 ? nlohmann::json::parse(result.out) : nlohmann::json();
  }
  test::TemporaryFolder folder;
};

TEST_F(RawCommands, InfoNamesTheEncodingAndBothStreams) {
  const nlohmann::json info = json_of("info --check --json a.raw").at("recordings").at(0);
  EXPECT_EQ(info.at("format"), "EVT3");
  EXPECT_EQ(info.at("data_table").at("state"), "none");
  EXPECT_EQ(info.at("camera"), "Prophesee_42");
  EXPECT_EQ(info.at("width"), 640);
  EXPECT_EQ(info.at("healthy"), true);
  EXPECT_TRUE(info.at("notes").empty()) << info.at("notes");
  EXPECT_EQ(info.at("streams").at(0).at("elements"), 20'000);
  EXPECT_EQ(info.at("streams").at(1).at("elements"), 20);
}

TEST_F(RawCommands, ConvertKeepsEventsAndTriggers) {
  const nlohmann::json made = json_of("convert --json a.raw a.aedat4");
  EXPECT_EQ(made.at("compression"), "lz4");
  EXPECT_EQ(made.at("streams").at(0).at("elements"), 20'000);
  EXPECT_EQ(made.at("streams").at(1).at("type"), "triggers");
  EXPECT_EQ(made.at("streams").at(1).at("elements"), 20);
  json_of("convert --json a.raw from-raw.csv");
  json_of("convert --json a.aedat4 from-aedat4.csv");
  const std::string csv = read_text(folder / "from-raw.csv");
  EXPECT_EQ(csv, read_text(folder / "from-aedat4.csv"));
  EXPECT_TRUE(csv.starts_with("t_us,x,y,on\n4096,0,0,0\n4106,1,1,1\n")) << csv.substr(0, 60);
  EXPECT_EQ(json_of("convert --json a.raw cut.aedat4 --from-us +50000 --to-us +60000").at("streams").at(0).at("elements"), 1'000);
  const test::CommandResult written = run_tactile("convert a.aedat4 b.raw", folder.path());
  EXPECT_EQ(written.exit_code, 1);
  EXPECT_NE(written.err.find("RAW can be read, but not written"), std::string::npos) << written.err;
}

TEST_F(RawCommands, ConvertPrintsTheStartOnce) {
  const test::CommandResult result = run_tactile("convert a.raw a.aedat4", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("  start     4096 us\n"), std::string::npos) << result.out;
}

TEST_F(RawCommands, RecordMakesARunOfIt) {
  json_of("record --from file:a.raw --speed 0 --object fan --json");
  const nlohmann::json info = json_of("info --check --json data/fan/01").at("recordings").at(0);
  EXPECT_EQ(info.at("format"), "AEDAT4");
  EXPECT_EQ(info.at("healthy"), true) << info.at("reasons");
  EXPECT_EQ(info.at("streams").at(0).at("elements"), 20'000);
  EXPECT_EQ(info.at("streams").at(1).at("elements"), 20);
  EXPECT_EQ(info.at("last_us"), 4'096 + 199'990);
}

TEST_F(RawCommands, ViewDrawsIt) {
  const test::CommandResult viewed = run_tactile("view a.raw --out sheet.png --tiles 2", folder.path());
  EXPECT_EQ(viewed.exit_code, 0) << viewed.err;
  EXPECT_GT(fs::file_size(folder / "sheet.png"), 1'000U);
}

TEST_F(RawCommands, RepairReportsThatItIsNone) {
  const test::CommandResult result = run_tactile("repair a.raw b.aedat4", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("is a Prophesee RAW file, which has no packets to repair"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace tactile::cli
