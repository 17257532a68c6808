#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

using nlohmann::json;
using test::run_tactile;

class LabelExchange : public testing::Test {
 protected:
  void SetUp() override {
    const auto made = run_tactile("simulate --preset tiny --objects fan,usb-hub --runs 1", folder.path());
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }

  test::CommandResult label(const std::string& arguments) { return run_tactile("label " + arguments, folder.path()); }

  json result_of(const std::string& arguments) {
    const test::CommandResult result = label(arguments + " --json");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }

  /// The command ends with 1, says `part`, and leaves fan/01's labels alone.
  void expect_refused(const std::string& arguments, const std::string& part) {
    const std::string before = text_of("data/fan/01/labels.json");
    const test::CommandResult result = label(arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    EXPECT_EQ(text_of("data/fan/01/labels.json"), before) << arguments;
  }

  std::string text_of(const std::string& file) const { return read_text(folder / file); }

  void replace(const std::string& file, const std::string& what, const std::string& by) {
    std::string text = text_of(file);
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos) << text;
    write_whole(folder / file, text.replace(at, what.size(), by));
  }

  test::TemporaryFolder folder;
};

TEST_F(LabelExchange, EveryFormatComesBackWithoutAChange) {
  ASSERT_EQ(label("").exit_code, 0);
  const std::string before = text_of("data/fan/01/labels.json");
  for (const std::string format : {"label-studio", "csv"}) {
    const json exported = result_of(fmt::format("--export out/{0} --format {0}", format)).at("exported");
    ASSERT_EQ(exported.size(), 2U);
    EXPECT_TRUE(std::filesystem::exists(folder / exported.at(0).at("file").get<std::string>()));
    const json imported = result_of("--import out/" + format).at("imported");
    ASSERT_EQ(imported.size(), 2U) << format;
    for (const json& run : imported) {
      EXPECT_GE(run.at("kept"), 2) << run;
      EXPECT_EQ(run.at("confirmed").get<int>() + run.at("moved").get<int>() + run.at("added").get<int>() +
                    run.at("rejected").get<int>(),
                0)
          << run;
    }
    EXPECT_EQ(text_of("data/fan/01/labels.json"), before) << format;
  }
  for (const char* file : {"all.csv", "tasks.json"}) {
    EXPECT_EQ(result_of(std::string("--export ") + file).at("exported").size(), 2U);
    EXPECT_EQ(result_of(std::string("--import ") + file).at("imported").size(), 2U);
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "tasks.xml"));
}

TEST_F(LabelExchange, LabelsFirstWhereThereAreNone) {
  const json result = result_of("data/fan/01 --export labels.csv");
  const json labelled = {"fan/01"};
  EXPECT_EQ(result.at("labelled"), labelled);
  EXPECT_TRUE(std::filesystem::exists(folder / "data/fan/01/labels.json"));
}

TEST_F(LabelExchange, EditsInASpreadsheetBecomeThePersonsAndOutliveRelabelling) {
  ASSERT_EQ(label("data/fan/01 --export labels.csv").exit_code, 0);
  // The press is taken away, the slip confirmed, and a press added.
  std::istringstream lines(text_of("labels.csv"));
  std::string line, header, edited;
  std::getline(lines, header);
  while (std::getline(lines, line)) {
    if (line.find("press-1") != std::string::npos) continue;
    const std::size_t unconfirmed = line.find(",false,");
    ASSERT_NE(unconfirmed, std::string::npos) << line;
    edited += line.replace(unconfirmed, 7, line.find("slip-1") != std::string::npos ? ",true," : ",false,") + "\n";
  }
  const auto commas = static_cast<std::size_t>(std::count(header.begin(), header.end(), ','));
  write_whole(folder / "labels.csv",
              header + "\n" + edited + "fan/01,,press,0.250000,0.400000" + std::string(commas - 4, ',') + "\n", IfThere::replace);
  const json run = result_of("data/fan/01 --import labels.csv").at("imported").at(0);
  EXPECT_EQ(run.at("added"), 1) << run;
  EXPECT_EQ(run.at("confirmed"), 1) << run;
  EXPECT_EQ(run.at("rejected"), 1) << run;
  const json labels = json::parse(text_of("data/fan/01/labels.json"));
  const std::string source = labels.at("intervals").at(0).at("source");
  EXPECT_EQ(source, "person");
  EXPECT_EQ(labels.at("rejected").size(), 1U);
  ASSERT_EQ(label("").exit_code, 0);
  const json again = json::parse(text_of("data/fan/01/labels.json"));
  EXPECT_EQ(again.at("intervals").at(0), labels.at("intervals").at(0));
  EXPECT_EQ(again.at("rejected"), labels.at("rejected"));
  ASSERT_EQ(label("--force").exit_code, 0);
  EXPECT_TRUE(json::parse(text_of("data/fan/01/labels.json")).at("rejected").empty());
}

TEST_F(LabelExchange, AnAnswerInLabelStudioConfirmsARunAndLeavesTheOthers) {
  ASSERT_EQ(label("--export tasks.json").exit_code, 0);
  json tasks = json::parse(text_of("tasks.json"));
  EXPECT_GT(tasks.at(0).at("data").at("signals").at("time_s").size(), 1000U);
  EXPECT_EQ(tasks.at(0).at("data").at("signals").at("tcp_height_mm").size(),
            tasks.at(0).at("data").at("signals").at("time_s").size());
  tasks[0]["annotations"] =
      json::array({{{"id", 7}, {"was_cancelled", true}, {"result", json::array()}},
                   {{"id", 8}, {"was_cancelled", false}, {"result", tasks[0]["predictions"][0]["result"]}}});
  write_whole(folder / "answered.json", tasks.dump());
  const json imported = result_of("--import answered.json").at("imported");
  EXPECT_TRUE(imported.at(0).at("looked_at").get<bool>());
  EXPECT_GE(imported.at(0).at("confirmed"), 2);
  EXPECT_EQ(imported.at(0).at("moved"), 0);
  EXPECT_FALSE(imported.at(1).at("looked_at").get<bool>());
}

TEST_F(LabelExchange, WhatIsThereAlreadyIsReplacedOnlyIfForced) {
  ASSERT_EQ(label("data/fan/01 --export labels.csv").exit_code, 0);
  ASSERT_EQ(label("data/fan/01 --export labels.csv").exit_code, 0) << "the same again is no loss";
  write_whole(folder / "labels.csv", "somebody's work");
  expect_refused("data/fan/01 --export labels.csv", "labels.csv: exists already");
  EXPECT_EQ(text_of("labels.csv"), "somebody's work");
  ASSERT_EQ(label("data/fan/01 --export labels.csv --force").exit_code, 0);
  EXPECT_NE(text_of("labels.csv"), "somebody's work");
  expect_refused("data/fan/01 --export data/fan/01/labels.json --force", "is a file of the run itself");
}

TEST_F(LabelExchange, WhatCannotBeImportedChangesNothing) {
  ASSERT_EQ(label("--export all.csv").exit_code, 0);
  ASSERT_EQ(label("--export out --format csv").exit_code, 0);
  write_whole(folder / "broken.csv", text_of("all.csv") + "fan/09,,press,1.0,2.0,,,,,,,,,,,,,,,,\n");
  expect_refused("--import broken.csv", "has labels of 'fan/09'; expected labels of fan/01, usb-hub/01");
  expect_refused("data/usb-hub/01 --import out/fan-01.csv", "has labels of 'fan/01'; expected labels of usb-hub/01");
  expect_refused("--import out/fan-01.csv --import all.csv", "expected each run once");
  write_whole(folder / "nameless.csv", "class,start_s,end_s\nslip,9.0,9.5\n");
  expect_refused("--import nameless.csv", "names no run");
  expect_refused("data/fan/01 --import nameless.csv", "outside the recording");
  expect_refused("--import missing.csv", "missing.csv: is missing");
  for (const char* other : {"all.xls", "fan-01.eaf", "fan-01.txt"}) {
    expect_refused(std::string("--import ") + other,
                   std::string(other) +
                       ": its ending names no format that labels are read from; expected .json of Label Studio, or .csv with the "
                       "columns class, start_s and end_s");
  }
  expect_refused("--import data", "holds no file of the runs");
  expect_refused("--export one.eaf", "its ending names no format; expected .json (Label Studio) or .csv");
  expect_refused("--export folder", "its ending names no format");
  std::filesystem::remove(folder / "data/fan/01/video.mp4");
  ASSERT_EQ(label("data/fan/01").exit_code, 0);
  expect_refused("data/fan/01 --export labels.csv --origin video", "its video clock is unknown");
}

TEST_F(LabelExchange, ImportAndExportDoNotGoTogether) {
  EXPECT_NE(label("--import a.csv --export b.csv").exit_code, 0);
  EXPECT_NE(label("--import a.csv --force").exit_code, 0);
  EXPECT_NE(label("--export a.csv --compare-truth").exit_code, 0);
  EXPECT_NE(label("--export a.csv --format word").exit_code, 0);
}

/// A run whose film's clock is known: a file can count from its first frame.
TEST_F(LabelExchange, TimesOfAVideoCountFromItsFirstFrame) {
  ASSERT_EQ(label("").exit_code, 0);
  json labels = json::parse(text_of("data/fan/01/labels.json"));
  const json truth = json::parse(text_of("data/fan/01/truth.json"));
  json clock = truth.at("clocks").at("video");
  clock.update({{"anchors", 1}, {"method", "known"}});
  labels["clocks"]["video"] = clock;
  write_whole(folder / "data/fan/01/labels.json", labels.dump());
  const json exported = result_of("data/fan/01 --export film.csv --origin video").at("exported").at(0);
  const std::string origin = exported.at("origin");
  EXPECT_EQ(origin, "video");
  // By the clock's own formula: when the film, which counts from 0, shows the press's start.
  const json& first = labels.at("intervals").at(0);
  const std::int64_t start = first.at("start_us"), offset = clock.at("offset_us");
  const double shown_s = static_cast<double>(start - offset) / (1 + 1e-6 * clock.at("drift_ppm").get<double>()) / 1e6;
  const std::string text = text_of("film.csv"), begin = first.at("id").get<std::string>() + ",press,";
  const std::size_t at = text.find(begin);
  ASSERT_NE(at, std::string::npos) << text;
  EXPECT_NEAR(std::stod(text.substr(at + begin.size())), shown_s, 2e-6) << text;
  const json imported = result_of("data/fan/01 --import film.csv").at("imported").at(0);
  EXPECT_EQ(imported.at("moved"), 0);
  EXPECT_GE(imported.at("kept"), 2);
}

}  // namespace
}  // namespace tactile::cli
