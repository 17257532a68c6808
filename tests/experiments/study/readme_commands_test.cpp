#include <gtest/gtest.h>

#include <filesystem>

#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

/// What a person, or 'tactile label', finds doubtful about the run's slip.
void flag_slip(const fs::path& run) {
  const fs::path file = run / "labels.json";
  labels::Labels labels = labels::read_labels(file);
  for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
    if (labels.intervals[i].touch == Touch::slip) labels.flags.push_back({i, "it slides", false});
  }
  labels::write_labels(file, labels);
}

/// The README's commands on the preset `tiny`, with one epoch, each expected to end with 0.
class ReadmeCommands : public testing::Test {
 protected:
  test::CommandResult ends_well(const std::string& arguments) const {
    test::CommandResult result = test::run_tactile(arguments, folder.path());
    EXPECT_EQ(result.exit_code, 0) << arguments << "\n" << result.err;
    return result;
  }
  nlohmann::json json_of(const std::string& arguments) const {
    return nlohmann::json::parse(ends_well(arguments + " --json").out, nullptr, false);
  }
  test::TemporaryFolder folder;
};

TEST_F(ReadmeCommands, EndWellWhereRunsOfSomeObjectsAreFlagged) {
  // With this seed the label of water-bottle/01 is flagged by itself, or was by the labels of its time.
  ends_well("simulate --preset tiny --seed 424243");
  ends_well("label --no-pictures");
  flag_slip(folder / "data/fan/01");
  flag_slip(folder / "data/usb-hub/01");
  flag_slip(folder / "data/usb-hub/02");
  const auto windows = ends_well("windows");
  EXPECT_NE(windows.err.find("usb-hub: left out, none of its runs has samples: slip-1 is flagged in usb-hub/01, usb-hub/02"),
            std::string::npos)
      << windows.err;
  EXPECT_NE(windows.err.find("'tactile view data/fan/01'"), std::string::npos) << windows.err;
  ends_well("heatmaps --th 40");

  const std::string in_place = "fan: trained on run 02 in place of 01, whose slip-1 is flagged";
  const auto train = json_of("train --th 40 --epochs 1");
  const auto train_runs = train.at("train_runs").get<Names>();
  EXPECT_NE(std::find(train_runs.begin(), train_runs.end(), "fan/02"), train_runs.end());
  EXPECT_TRUE(
      std::none_of(train_runs.begin(), train_runs.end(), [](const std::string& run) { return run.starts_with("usb-hub/"); }));
  EXPECT_GE(train_runs.size(), 5U) << "most objects have runs whose slip is not flagged";
  const auto warnings = train.at("warnings").get<Names>();
  EXPECT_EQ(std::count(warnings.begin(), warnings.end(), in_place), 1);
  EXPECT_NE(warnings.back().find("--include-flagged"), std::string::npos) << warnings.back();
  EXPECT_EQ(read_json(folder / "models" / train.at("name").get<std::string>() / "model.json").at("train_runs"),
            train.at("train_runs"));

  const auto eval = json_of("eval");
  const auto test_runs = eval.at("test_runs").get<Names>();
  EXPECT_EQ(std::find(test_runs.begin(), test_runs.end(), "fan/02"), test_runs.end()) << "it was trained on";
  EXPECT_FALSE(eval.at("accuracy").at("objects").contains("fan")) << "none of its runs but 02 has samples";
  EXPECT_TRUE(eval.at("accuracy").at("objects").contains("water-bottle"));

  const auto unseen = json_of("eval --unseen");
  const auto compared = unseen.at("unseen").at("runs").get<Names>();
  EXPECT_EQ(std::find(compared.begin(), compared.end(), "fan/02"), compared.end()) << "one of the models was trained on it";
  const auto remarks = unseen.at("warnings").get<Names>();
  EXPECT_EQ(std::count(remarks.begin(), remarks.end(),
                       "fan: not compared, each of its runs with samples was used to train one of the models"),
            1);
  EXPECT_TRUE(unseen.at("unseen").at("objects").contains("small-box"));

  ends_well("export --onnx model.onnx --safetensors model.safetensors");
  ends_well("report");
  EXPECT_NE(read_text(folder / "report/report.html").find(in_place), std::string::npos);

  for (const char* command : {"windows --strict", "train --strict", "eval --strict", "eval --unseen --strict"}) {
    const auto strict = test::run_tactile(command, folder.path());
    EXPECT_EQ(strict.exit_code, 1) << command;
    EXPECT_NE(strict.err.find("as --strict asks for"), std::string::npos) << command << strict.err;
  }
}

TEST_F(ReadmeCommands, StudyRunsThatAreFlaggedOrTakesThemWithTheirFlags) {
  ends_well("simulate --preset tiny --objects fan,small-box,water-bottle --runs 3");
  ends_well("label --no-pictures");
  flag_slip(folder / "data/fan/01");
  for (const char* run : {"01", "02", "03"}) flag_slip(folder / "data/small-box" / run);
  const std::string reproduce = "reproduce --preset quick --th 40 --epochs 1 --steps 10 --trainings 1 --held-out fan --no-report";
  const auto study = json_of(reproduce);
  EXPECT_EQ(study.at("remarks"), (Names{"fan: trained on run 02 in place of 01, whose slip-1 is flagged",
                                        "small-box: left out, none of its runs has samples: slip-1 is flagged in small-box/01, "
                                        "small-box/02, small-box/03"}));
  EXPECT_EQ(study.at("unseen")[0].at("accuracy").at("runs"), Names{"fan/03"});
  const auto whole = study.at("results")[0].at("whole_runs").at("runs").get<Names>();
  EXPECT_EQ(whole,
            (Names{"fan/01", "fan/03", "small-box/01", "small-box/02", "small-box/03", "water-bottle/02", "water-bottle/03"}))
      << "flagged ones are judged, too";

  const auto strict = test::run_tactile(reproduce + " --strict", folder.path());
  EXPECT_EQ(strict.exit_code, 1);
  EXPECT_NE(strict.err.find("small-box: left out"), std::string::npos) << strict.err;

  const auto again = json_of(reproduce + " --include-flagged --strict");
  EXPECT_TRUE(again.at("remarks").empty());
  EXPECT_EQ(again.at("settings").at("include_flagged"), true);
  EXPECT_EQ(again.at("results")[0].at("whole_runs").at("runs").size(), 6U);
}

TEST_F(ReadmeCommands, EndWith1OnceTheOtherRunsAreDoneWhereOneCannotBeRead) {
  ends_well("simulate --preset tiny --objects small-box,uhu-glue-stick,water-bottle --runs 3");
  ends_well("label --no-pictures");
  write_whole(folder / "data/small-box/03/run.json", "null");
  const auto train = test::run_tactile("train --epochs 1", folder.path());
  EXPECT_EQ(train.exit_code, 1);
  EXPECT_NE(train.err.find("small-box/03/run.json"), std::string::npos) << train.err;
  EXPECT_NE(train.out.find("th40-single-1"), std::string::npos) << train.out;

  fs::remove(folder / "data/small-box/03/labels.json");
  for (const bool kept : {false, true}) {
    const auto study = test::run_tactile(
        "reproduce --preset quick --th 40 --epochs 1 --steps 10 --trainings 1 --held-out small-box --no-report --json",
        folder.path());
    EXPECT_EQ(study.exit_code, 1);
    EXPECT_NE(study.err.find("small-box/03"), std::string::npos) << study.err;
    const auto json = nlohmann::json::parse(study.out);
    EXPECT_EQ(json.at("worlds")[0].at("runs"), 8) << "all others";
    EXPECT_EQ(json.at("errors").size(), 1U) << json.at("errors");
    EXPECT_EQ(json.at("steps_done") == 0, kept);
  }
}

}  // namespace
}  // namespace tactile::study
