#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using test::run_tactile;
const std::string vendor_file = std::string(test::data_folder) + "/aedat4/dv-lz4.aedat4";

TEST(ConvertCommand, GoesToCsvAndBack) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_tactile("convert " + vendor_file + " a.csv", folder.path()).exit_code, 0);
  EXPECT_EQ(run_tactile("convert a.csv b.aedat4 --size 160x120 --source DVXplorer_DXM00042 --compression zstd", folder.path())
                .exit_code,
            0);
  EXPECT_EQ(run_tactile("convert b.aedat4 c.csv", folder.path()).exit_code, 0);
  EXPECT_EQ(read_text(folder / "a.csv"), read_text(folder / "c.csv"));
  const nlohmann::json info =
      nlohmann::json::parse(run_tactile("info --json b.aedat4", folder.path()).out).at("recordings").at(0);
  EXPECT_EQ(info.at("camera"), "DVXplorer_DXM00042");
  EXPECT_EQ(info.at("compression"), "zstd");
  EXPECT_EQ(info.at("width"), 160);
}

TEST(ConvertCommand, CutsHalfOpenAndReportsWhatItWrote) {
  const test::TemporaryFolder folder;
  const test::CommandResult result = run_tactile(
      "convert --json --from-us 1700000011005000 --to-us 1700000011010033 " + vendor_file + " cut.aedat4", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_GE(json.at("first_us"), 1700000011005000);
  EXPECT_LT(json.at("last_us"), 1700000011010033);
  EXPECT_EQ(json.at("bytes_out"), fs::file_size(folder / "cut.aedat4"));
  EXPECT_EQ(run_tactile("info --check cut.aedat4", folder.path()).exit_code, 0);
}

TEST(ConvertCommand, CountsFromTheFirstElementWhereAskedTo) {
  const test::TemporaryFolder folder;
  write_whole(folder / "a.csv", "t_us,x,y,on\n7000,1,1,1\n7010,2,1,1\n7020,3,1,0\n7030,4,1,0\n");
  for (const char* command :
       {"convert a.csv a.aedat4 --size 320x240", "convert a.aedat4 a.h5", "convert a.aedat4 b.csv --from-us +10 --to-us +30",
        "convert a.h5 c.aedat4 --from-us +10 --to-us 7030", "convert c.aedat4 c.csv",
        "convert a.csv d.aedat4 --size 320x240 --from-us 7010 --to-us +30", "convert d.aedat4 d.csv"}) {
    const test::CommandResult result = run_tactile(command, folder.path());
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.err;
  }
  for (const char* file : {"b.csv", "c.csv", "d.csv"})
    EXPECT_EQ(read_text(folder / file), "t_us,x,y,on\n7010,2,1,1\n7020,3,1,0\n") << file;
  const test::CommandResult useless = run_tactile("convert a.aedat4 e.csv --from-us 10", folder.path());
  EXPECT_EQ(useless.exit_code, 0);
  EXPECT_NE(useless.err.find("--from-us 10: cuts nothing"), std::string::npos) << useless.err;
  EXPECT_NE(useless.err.find("'+10'"), std::string::npos) << useless.err;
  EXPECT_EQ(run_tactile("convert a.aedat4 f.csv --from-us +30 --to-us +10", folder.path()).exit_code, 1);
  EXPECT_GE(run_tactile("convert a.aedat4 f.csv --from-us +-5", folder.path()).exit_code, 100);
}

TEST(ConvertCommand, TakesARunForItsRecording) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "data/fan/01");
  fs::copy_file(vendor_file, folder / "data/fan/01/events.aedat4");
  EXPECT_EQ(run_tactile("convert data/fan/01 a.csv", folder.path()).exit_code, 0);
  EXPECT_EQ(run_tactile("convert " + vendor_file + " b.csv", folder.path()).exit_code, 0);
  EXPECT_EQ(read_text(folder / "a.csv"), read_text(folder / "b.csv"));
  const test::CommandResult all = run_tactile("convert data c.csv", folder.path());
  EXPECT_EQ(all.exit_code, 1);
  EXPECT_NE(all.err.find("such as data/fan/01"), std::string::npos) << all.err;
}

TEST(ConvertCommand, ReportsThatItGuessedTheSensor) {
  const test::TemporaryFolder folder;
  write_whole(folder / "a.csv", "t_us,x,y,on\n0,339,0,1\n");
  const test::CommandResult result = run_tactile("convert a.csv a.aedat4", folder.path());
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("346x260"), std::string::npos) << result.err;
}

TEST(ConvertCommand, ReportsInOneLineWhatIsWrong) {
  const test::TemporaryFolder folder;
  write_whole(folder / "bad.csv", "t_us,x,y,on\n5,1,1,1\n4,1,1,1\n");
  const auto error_of = [&](const std::string& arguments) {
    const test::CommandResult result = run_tactile("convert " + arguments, folder.path());
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    return result.err;
  };
  EXPECT_NE(error_of("bad.csv out.aedat4").find("bad.csv:3: time goes back from 5 to 4 us"), std::string::npos);
  EXPECT_NE(error_of(vendor_file + " out.npy").find(".aedat4, .csv, .h5 or .npz"), std::string::npos);
  EXPECT_NE(error_of(vendor_file + " out.csv --to-us 5").find("contains no element"), std::string::npos);
  EXPECT_NE(error_of("missing.aedat4 out.csv").find("missing.aedat4"), std::string::npos);
  EXPECT_NE(error_of(vendor_file + " " + vendor_file + " --force").find("never replaced"), std::string::npos);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(ConvertCommand, RefusesValuesOutOfRangeAsAUsageError) {
  const test::TemporaryFolder folder;
  write_whole(folder / "a.csv", "t_us,x,y,on\n0,1,1,1\n");
  for (const char* option : {"--size 640", "--size 0x480", "--size 640x40000", "--compression gzip", "--from-us soon",
                             "--crop 5,5", "--crop=-1,0,5x5", "--crop 0,0,5x0"}) {
    const test::CommandResult result = run_tactile(std::string("convert a.csv b.aedat4 ") + option, folder.path());
    EXPECT_GT(result.exit_code, 2) << option;
    EXPECT_FALSE(fs::exists(folder / "b.aedat4"));
  }
}

TEST(ConvertCommand, CropsIntoEveryFormat) {
  const test::TemporaryFolder folder;
  for (const char* out : {"a.aedat4", "a.csv", "a.h5", "a.npz"}) {
    const test::CommandResult result =
        run_tactile("convert --json --crop 40,30,80x60 --stream 0 " + vendor_file + " " + out, folder.path());
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json.at("width"), 80);
    EXPECT_EQ(json.at("height"), 60);
    EXPECT_GT(json.at("cropped_events"), 0);
    EXPECT_EQ(json.at("cropped_events").get<int>() + json.at("streams").at(0).at("elements").get<int>(), 6'000) << out;
  }
}

TEST(ConvertCommand, MakesARunOfABag) {
  const test::TemporaryFolder folder;
  const std::string bags = std::string(test::data_folder) + "/bags/";
  const test::CommandResult result = run_tactile("convert --json " + bags + "run-lz4.bag data/mug/01", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("events"), 3'000);
  EXPECT_EQ(json.at("robot_states"), 126);
  EXPECT_EQ(json.at("frames"), 6);
  EXPECT_EQ(json.at("topics").size(), 6U);
  EXPECT_EQ(run_tactile("info --check data/mug/01", folder.path()).exit_code, 0);
  const auto error_of = [&](const std::string& arguments) {
    const test::CommandResult refused = run_tactile("convert " + arguments, folder.path());
    EXPECT_EQ(refused.exit_code, 1) << arguments;
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
    return refused.err;
  };
  EXPECT_NE(error_of(bags + "run.bag data/mug/01 --force").find("never replaced"), std::string::npos);
  EXPECT_NE(error_of(bags + "run.bag out.mat").find("is not a run folder"), std::string::npos);
  EXPECT_NE(error_of(bags + "run.bag data/mug/02 --crop 0,0,5x5").find("a bag is converted completely"), std::string::npos);
  EXPECT_NE(error_of(vendor_file + " out.csv --events-topic /a").find("is not a bag"), std::string::npos);
  write_whole(folder / "trip.mcap", "x");
  EXPECT_NE(error_of("trip.mcap data/mug/02").find("trip.mcap: does not begin as a bag; expected one of ROS 1"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "data/mug/02"));
}

TEST(ConvertCommand, MakesARecordingOfABagToo) {
  const test::TemporaryFolder folder;
  const std::string bags = std::string(test::data_folder) + "/bags/";
  for (const auto& [name, format] :
       {std::pair("mono.bag", "ROS 1 bag"), std::pair("mono.db3", "ROS 2 bag"), std::pair("mono.mcap", "ROS 2 bag")}) {
    const auto made = run_tactile("convert " + bags + name + " " + name + ".csv", folder.path());
    ASSERT_EQ(made.exit_code, 0) << name;
    EXPECT_NE(made.out.find(fmt::format("  from      {}{}, {}", bags, name, format)), std::string::npos) << made.out;
    const auto again = run_tactile("convert --json --force " + bags + name + " " + name + ".csv", folder.path());
    EXPECT_EQ(nlohmann::json::parse(again.out).at("bytes_in"), std::filesystem::file_size(bags + name)) << name;
    EXPECT_EQ(read_text(folder / (std::string(name) + ".csv")), read_text(folder / "mono.bag.csv")) << name;
  }
  const test::CommandResult cut = run_tactile("convert --json " + bags + "run-lz4.mcap part.aedat4 --to-us +5000", folder.path());
  ASSERT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_EQ(nlohmann::json::parse(cut.out).at("in"), bags + "run-lz4.mcap");
}

TEST(ConvertCommand, IsNamedByCommandsThatDoNotReadBags) {
  const test::TemporaryFolder folder;
  const std::string bags = std::string(test::data_folder) + "/bags/";
  fs::create_directory(folder / "bag");
  fs::copy_file(bags + "mono.db3", folder / "bag" / "mono.db3");
  for (const std::string& command :
       {"characterise " + bags + "mono.db3", "characterise " + bags + "mono.mcap", std::string("characterise bag"),
        "record --from file:" + bags + "mono.bag", std::string("record --from file:bag"), "serve " + bags + "mono.bag"}) {
    const test::CommandResult result = run_tactile(command, folder.path());
    EXPECT_EQ(result.exit_code, 1) << command;
    EXPECT_NE(result.err.find("is a ROS bag, not a recording; expected what 'tactile convert' makes of it"), std::string::npos)
        << command << "\n"
        << result.err;
  }
}

TEST(InfoCommand, ListsTheTopicsOfABag) {
  const test::TemporaryFolder folder;
  const std::string bags = std::string(test::data_folder) + "/bags/";
  for (const char* name : {"run.bag", "run-message.db3", "run-zstd.mcap"}) {
    const test::CommandResult result = run_tactile("info --json " + bags + name, folder.path());
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json bag = nlohmann::json::parse(result.out).at("bags").at(0);
    ASSERT_EQ(bag.at("topics").size(), 6U) << name;
    const nlohmann::json& topic = bag.at("topics").at(2);
    EXPECT_EQ(topic.at("name"), "/dvs/events");
    EXPECT_EQ(topic.at("events").at("events"), 3000) << name;
    EXPECT_EQ(topic.at("events").at("width"), 160) << name;
    EXPECT_TRUE(bag.at("reasons").empty());
  }
  EXPECT_EQ(run_tactile("info --check " + bags + "mono.db3", folder.path()).exit_code, 2);  // a packet is lost
}

}  // namespace
}  // namespace tactile::cli
