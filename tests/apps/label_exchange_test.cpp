#include <gtest/gtest.h>

#include <cmath>
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
  for (const std::string format : {"audacity", "elan", "label-studio", "csv"}) {
    const json exported = result_of("--export out/" + format + " --format " + format).at("exported");
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
  const json result = result_of("data/fan/01 --export labels.txt");
  const json labelled = {"fan/01"};
  EXPECT_EQ(result.at("labelled"), labelled);
  EXPECT_TRUE(std::filesystem::exists(folder / "data/fan/01/labels.json"));
}

TEST_F(LabelExchange, EditsInAudacityBecomeThePersonsAndOutliveRelabelling) {
  ASSERT_EQ(label("data/fan/01 --export labels.txt").exit_code, 0);
  // What Audacity leaves when the press is taken away, the slip marked, and a press drawn.
  std::istringstream lines(text_of("labels.txt"));
  std::string line, edited;
  while (std::getline(lines, line)) {
    if (line.find("press-1") != std::string::npos) continue;
    edited += line + (line.find("slip-1") != std::string::npos ? " ok" : "") + "\n";
  }
  write_whole(folder / "labels.txt", edited + "0.250000\t0.400000\tpress\n");
  const json run = result_of("data/fan/01 --import labels.txt").at("imported").at(0);
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
  ASSERT_EQ(label("data/fan/01 --export labels.txt").exit_code, 0);
  ASSERT_EQ(label("data/fan/01 --export labels.txt").exit_code, 0) << "the same again is no loss";
  write_whole(folder / "labels.txt", "somebody's work");
  expect_refused("data/fan/01 --export labels.txt", "labels.txt: exists already");
  EXPECT_EQ(text_of("labels.txt"), "somebody's work");
  ASSERT_EQ(label("data/fan/01 --export labels.txt --force").exit_code, 0);
  EXPECT_NE(text_of("labels.txt"), "somebody's work");
  expect_refused("data/fan/01 --export data/fan/01/labels.json --force", "is a file of the run itself");
}

TEST_F(LabelExchange, WhatCannotBeImportedChangesNothing) {
  ASSERT_EQ(label("--export all.csv").exit_code, 0);
  ASSERT_EQ(label("--export out --format audacity").exit_code, 0);
  write_whole(folder / "broken.csv", text_of("all.csv") + "fan/09,,press,1.0,2.0,,,,,,,,,,,,,,\n");
  expect_refused("--import broken.csv", "has labels of 'fan/09'; expected labels of fan/01, usb-hub/01");
  expect_refused("data/usb-hub/01 --import out/fan-01.txt", "has labels of 'fan/01'; expected labels of usb-hub/01");
  expect_refused("--import out/fan-01.txt --import all.csv", "expected each run once");
  replace("out/fan-01.txt", "0.000000\t0.000000\t# fan/01 from first-event\n", "9.000000\t9.500000\tslip\n");
  std::filesystem::rename(folder / "out/fan-01.txt", folder / "nameless.txt");
  expect_refused("--import nameless.txt", "names no run");
  expect_refused("data/fan/01 --import nameless.txt", "outside the recording");
  expect_refused("--import missing.eaf", "missing.eaf: is missing");
  expect_refused("--import all.xls", "its ending names no format");
  expect_refused("--import data", "holds no file of the runs");
  expect_refused("--export one.eaf", "holds one run, and there are 2");
  expect_refused("--export folder", "its ending names no format");
  std::filesystem::remove(folder / "data/fan/01/video.mp4");
  ASSERT_EQ(label("data/fan/01").exit_code, 0);
  expect_refused("data/fan/01 --export labels.txt --origin video", "its video clock is unknown");
}

TEST_F(LabelExchange, ImportAndExportDoNotGoTogether) {
  EXPECT_NE(label("--import a.txt --export b.txt").exit_code, 0);
  EXPECT_NE(label("--import a.txt --force").exit_code, 0);
  EXPECT_NE(label("--export a.txt --compare-truth").exit_code, 0);
  EXPECT_NE(label("--export a.txt --format word").exit_code, 0);
}

/// A run whose film's clock is known: the document counts from its first frame, and ELAN finds it.
TEST_F(LabelExchange, ElanGetsTheFilmInStep) {
  ASSERT_EQ(label("").exit_code, 0);
  json labels = json::parse(text_of("data/fan/01/labels.json"));
  const json truth = json::parse(text_of("data/fan/01/truth.json"));
  json clock = truth.at("clocks").at("video");
  clock.update({{"residual_us", 1.0}, {"anchors", 1}, {"method", "known"}});
  labels["clocks"]["video"] = clock;
  write_whole(folder / "data/fan/01/labels.json", labels.dump());
  const json exported = result_of("data/fan/01 --export data/fan/01/labels.eaf").at("exported").at(0);
  const std::string origin = exported.at("origin");
  EXPECT_EQ(origin, "video");
  const std::string text = text_of("data/fan/01/labels.eaf");
  EXPECT_NE(text.find("RELATIVE_MEDIA_URL=\"./video.mp4\""), std::string::npos) << text;
  // By the clock's own formula: when the film, which counts from 0, shows the press's start.
  const std::int64_t start = labels.at("intervals").at(0).at("start_us"), offset = clock.at("offset_us");
  const auto shown_ms = static_cast<std::int64_t>(
      std::llround(static_cast<double>(start - offset) / (1 + 1e-6 * clock.at("drift_ppm").get<double>()) / 1000));
  EXPECT_NE(text.find("TIME_VALUE=\"" + std::to_string(shown_ms) + "\""), std::string::npos) << shown_ms << text;
  const json imported = result_of("data/fan/01 --import data/fan/01/labels.eaf").at("imported").at(0);
  EXPECT_EQ(imported.at("moved"), 0);
  EXPECT_GE(imported.at("kept"), 2);
}

}  // namespace
}  // namespace tactile::cli
