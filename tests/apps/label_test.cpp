#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

using test::run_tactile;

class LabelCommand : public testing::Test {
 protected:
  void SetUp() override {
    const auto made = run_tactile("simulate --preset tiny --objects fan,usb-hub --runs 1", folder.path());
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  /// The run gets a flag.
  void leave_incomplete(const std::string& run) const {
    const auto file = folder.path() / run / "run.json";
    auto info = nlohmann::json::parse(read_text(file));
    info["complete"] = false;
    write_whole(file, info.dump());
  }
  test::TemporaryFolder folder;
};

TEST_F(LabelCommand, GivesTheSameBytesWithoutTheTruthAndForAnyThreads) {
  ASSERT_EQ(run_tactile("label --threads 1", folder.path()).exit_code, 0);
  const std::string first = read_text(folder.path() / "data/fan/01/labels.json");
  std::filesystem::remove(folder.path() / "data/fan/01/truth.json");
  ASSERT_EQ(run_tactile("label --threads 2", folder.path()).exit_code, 0);
  EXPECT_EQ(read_text(folder.path() / "data/fan/01/labels.json"), first);
}

TEST_F(LabelCommand, ComparesWithTheTruthToMilliseconds) {
  const auto result = run_tactile("label --compare-truth --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto truth = nlohmann::json::parse(result.out).at("truth");
  EXPECT_EQ(truth.at("runs"), 2);
  EXPECT_EQ(truth.at("missed"), 0);
  EXPECT_EQ(truth.at("spurious"), 0);
  EXPECT_LE(truth.at("errors_ms").at("press_onset").at("max"), 10.0);
  EXPECT_LE(truth.at("errors_ms").at("slip_onset").at("max"), 20.0);
}

TEST_F(LabelCommand, NamesMisnamedRunsWithTheNameThatTheyNeed) {
  std::filesystem::rename(folder / "data/fan", folder / "data/Fan");
  const auto all = run_tactile("label --no-pictures --json", folder.path());
  EXPECT_EQ(all.exit_code, 0) << all.err;
  EXPECT_NE(all.err.find("data/Fan: its run is left out"), std::string::npos) << all.err;
  const auto json = nlohmann::json::parse(all.out);
  EXPECT_EQ(json.at("runs").size(), 1U);
  EXPECT_NE(json.at("misnamed").at(0).get<std::string>().find("rename it to fan"), std::string::npos);
  for (const char* place : {"data/Fan/01", "data/Fan"}) {
    const auto typed = run_tactile(std::string("label ") + place, folder.path());
    EXPECT_EQ(typed.exit_code, 1);
    EXPECT_NE(typed.err.find("data/Fan/01: an object's name is lower-case letters, digits and inner hyphens; rename the folder "
                             "Fan to fan"),
              std::string::npos)
        << typed.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "data/Fan/01/labels.json"));
}

TEST_F(LabelCommand, NamesAMisnamedRecordingOnce) {
  std::filesystem::rename(folder / "data/fan/01/events.aedat4", folder / "data/fan/01/Events.aedat4");
  std::filesystem::create_directories(folder / "data/fan/02");
  const auto result = run_tactile("label --no-pictures", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("data/fan/01: is left out, because a run's recording is named events.aedat4"), std::string::npos)
      << result.err;
  EXPECT_NE(result.err.find("events.aedat4 is missing: data/fan/02\n"), std::string::npos) << result.err;
}

TEST_F(LabelCommand, LabelsTheOthersWhereOneCannotBeRead) {
  std::filesystem::create_symlink("loop", folder / "data/loop");
  const auto result = run_tactile("label --no-pictures --json", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("tactile: data/loop: cannot be read (Too many levels of symbolic links)"), std::string::npos)
      << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("runs").size(), 2U);
  EXPECT_EQ(json.at("failed").size(), 1U);
  std::filesystem::remove(folder / "data/loop");

  const auto file = folder / "data/fan/01/labels.json";
  auto labels = nlohmann::json::parse(read_text(file));
  labels.at("intervals").at(0).at("class") = 5;
  write_whole(file, labels.dump());
  write_whole(folder / "data/usb-hub/01/truth.json", "[]");
  const auto bad = run_tactile("label --no-pictures --compare-truth --json", folder.path());
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_NE(bad.err.find("data/fan/01/labels.json: 'class' is a number; expected a text"), std::string::npos) << bad.err;
  EXPECT_NE(bad.err.find("data/usb-hub/01/truth.json: 'intervals' is missing"), std::string::npos) << bad.err;
  EXPECT_EQ(bad.err.find("json.exception"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(bad.out).at("runs").size(), 1U);

  const auto exported = run_tactile("label --export out --format csv --json", folder.path());
  EXPECT_EQ(exported.exit_code, 1);
  EXPECT_NE(exported.err.find("'class' is a number"), std::string::npos) << exported.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "out/usb-hub-01.csv"));
}

TEST_F(LabelCommand, KeepsLabelsThatAPersonConfirmedUnlessForced) {
  ASSERT_EQ(run_tactile("label", folder.path()).exit_code, 0);
  const auto file = folder.path() / "data/fan/01/labels.json";
  auto labels = nlohmann::json::parse(read_text(file));
  labels.at("intervals").at(0).at("confirmed") = true;
  write_whole(file, labels.dump());
  const auto again = run_tactile("label", folder.path());
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_NE(again.err.find("1 run unchanged"), std::string::npos) << again.err << "the picture of the other is drawn again";
  const auto is_confirmed = [&] {
    return nlohmann::json::parse(read_text(file)).at("intervals").at(0).at("confirmed").get<bool>();
  };
  EXPECT_TRUE(is_confirmed());
  EXPECT_NE(run_tactile("label", folder.path()).err.find("2 runs unchanged"), std::string::npos);
  EXPECT_EQ(run_tactile("label --force", folder.path()).exit_code, 0);
  EXPECT_FALSE(is_confirmed());
}

TEST_F(LabelCommand, NamesRunsWithTheSameRobotLog) {
  ASSERT_EQ(run_tactile("label --no-pictures --strict", folder.path()).exit_code, 0);
  std::filesystem::copy_file(folder / "data/usb-hub/01/robot.csv", folder / "data/fan/01/robot.csv",
                             std::filesystem::copy_options::overwrite_existing);
  const auto result = run_tactile("label --no-pictures --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("fan/01, usb-hub/01 have the same robot.csv"), std::string::npos) << result.err;
}

TEST_F(LabelCommand, GivesRunsASession) {
  const auto alone = run_tactile("label --no-pictures --session monday data/fan/01 data/usb-hub/01 --json", folder.path());
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  for (const char* run : {"fan/01", "usb-hub/01"})
    EXPECT_EQ(nlohmann::json::parse(read_text(folder / "data" / run / "run.json"))["session"], "monday");
  std::filesystem::remove(folder / "data/usb-hub/01/run.json");
  const auto refused = run_tactile("label data --no-pictures --session tuesday", folder.path());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("usb-hub/01 has no run.json"), std::string::npos) << refused.err;
  EXPECT_EQ(nlohmann::json::parse(read_text(folder / "data/fan/01/run.json"))["session"], "monday") << "none is changed";
  for (const char* wrong : {"label --session tuesday", "label data --session ''", "label data --session tuesday --export l.csv"})
    EXPECT_NE(run_tactile(wrong, folder.path()).exit_code, 0) << wrong;
}

TEST_F(LabelCommand, NamesARunThatCannotBeReadAndLabelsTheOthers) {
  write_whole(folder.path() / "data/fan/01/robot.csv", "");
  const auto result = run_tactile("label", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("fan/01/robot.csv"), std::string::npos) << result.err;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "data/usb-hub/01/labels.json"));
}

TEST_F(LabelCommand, FlagsARecordingThatWasCutOff) {
  std::filesystem::resize_file(folder.path() / "data/fan/01/events.aedat4", 900'000);
  const auto result = run_tactile("label data/fan/01 --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("cut off"), std::string::npos) << result.out;
}

TEST_F(LabelCommand, OfEventsThatChangedSinceAreNotUsed) {
  ASSERT_EQ(run_tactile("label", folder.path()).exit_code, 0);
  std::filesystem::copy_file(folder.path() / "data/usb-hub/01/events.aedat4", folder.path() / "data/fan/01/events.aedat4",
                             std::filesystem::copy_options::overwrite_existing);
  const auto result = run_tactile("windows --include-flagged", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("fan/01: left out"), std::string::npos) << result.err;
}

TEST_F(LabelCommand, IsNotUndoneByMakingTheSameRunAgain) {
  ASSERT_EQ(run_tactile("label", folder.path()).exit_code, 0);
  const std::string before = read_text(folder.path() / "data/fan/01/labels.json");
  std::filesystem::remove(folder.path() / "data/fan/01/truth.json");
  ASSERT_EQ(run_tactile("simulate --preset tiny --objects fan,usb-hub --runs 1", folder.path()).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "data/fan/01/truth.json"));
  EXPECT_EQ(read_text(folder.path() / "data/fan/01/labels.json"), before);
}

TEST_F(LabelCommand, WithoutTruthToCompareWithIsAnError) {
  for (const char* run : {"data/fan/01", "data/usb-hub/01"}) std::filesystem::remove(folder.path() / run / "truth.json");
  EXPECT_EQ(run_tactile("label --compare-truth", folder.path()).exit_code, 1);
}

std::size_t longest_line_in(const std::string& text) {
  std::size_t longest = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) longest = std::max(longest, characters_in(line));
  return longest;
}

TEST_F(LabelCommand, DrawsAPictureOfEachRunByDefault) {
  ASSERT_EQ(run_tactile("label data/fan/01", folder.path()).exit_code, 0);
  const std::string first = read_text(folder.path() / "data/fan/01/labels.png");
  EXPECT_EQ(first.substr(1, 3), "PNG");
  ASSERT_EQ(run_tactile("label data/fan/01 --force --threads 1", folder.path()).exit_code, 0);
  EXPECT_EQ(read_text(folder.path() / "data/fan/01/labels.png"), first);
  ASSERT_EQ(run_tactile("label data/usb-hub/01 --no-pictures", folder.path()).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "data/usb-hub/01/labels.json"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "data/usb-hub/01/labels.png"));
}

TEST_F(LabelCommand, LabelsWithoutPicturesWhereGnuplotIsNotInstalled) {
  std::filesystem::create_directory(folder / "nothing");
  const auto result =
      test::run_shell("PATH='" + (folder / "nothing").string() + "' '" + test::tactile_binary + "' label", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("2 pictures were not drawn (--no-pictures leaves them out): gnuplot: is not installed"),
            std::string::npos)
      << result.err;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "data/fan/01/labels.json"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "data/fan/01/labels.png"));
}

TEST_F(LabelCommand, SumsUpTheLabelsThatAreThereAndMakesNone) {
  EXPECT_EQ(run_tactile("label --summary", folder.path()).exit_code, 1) << "no run has labels";
  ASSERT_EQ(run_tactile("label data/fan/01 --no-pictures", folder.path()).exit_code, 0);
  const auto file = folder.path() / "data/fan/01/labels.json";
  auto labels = nlohmann::json::parse(read_text(file));
  const std::int64_t lift_us = labels.at("intervals").back().at("start_us").get<std::int64_t>() - 3'000;
  labels.at("intervals").back().at("evidence").at("robot_us") = lift_us;
  write_whole(file, labels.dump());
  const auto result = run_tactile("label --summary --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("usb-hub/01"), std::string::npos) << "has no labels: " << result.err;
  EXPECT_EQ(read_text(file), labels.dump()) << "nothing is labelled again";
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "data/usb-hub/01/labels.json"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "data/fan/01/labels.png"));

  const auto json = nlohmann::json::parse(result.out);
  ASSERT_EQ(json.at("runs").size(), 1U);
  EXPECT_EQ(json.at("runs")[0].at("lift_to_slip_us"), 3'000);
  ASSERT_EQ(json.at("objects").size(), 1U);
  EXPECT_EQ(json.at("objects")[0].at("object").get<std::string>(), "fan");
  EXPECT_DOUBLE_EQ(json.at("objects")[0].at("lift_to_slip").at("median_ms").get<double>(), 3.0);
  EXPECT_TRUE(json.at("objects")[0].at("lift_to_slip").at("spread_ms").is_null()) << "of one run there is none";
  const auto& differences = json.at("differences");
  const auto slip = std::find_if(differences.begin(), differences.end(), [](const nlohmann::json& d) {
    return d.at("class") == nlohmann::json("slip") && d.at("less") == nlohmann::json("robot");
  });
  ASSERT_NE(slip, differences.end());
  EXPECT_EQ(slip->at("of").get<std::string>(), "events");
  EXPECT_TRUE(slip->at("clock_method").is_string());
}

TEST_F(LabelCommand, ExplainsTheLagFromLiftToSlipOnlyWhereThereIsOne) {
  ASSERT_EQ(run_tactile("label data/fan/01 --no-pictures", folder.path()).exit_code, 0);
  const auto file = folder.path() / "data/fan/01/labels.json";
  auto labels = nlohmann::json::parse(read_text(file));
  const auto explanations = [&](const nlohmann::json& robot_us) {
    labels.at("intervals").back().at("evidence").at("robot_us") = robot_us;
    write_whole(file, labels.dump());
    std::string text = run_tactile("label data/fan/01 --summary", folder.path()).out;
    std::replace(text.begin(), text.end(), '\n', ' ');
    return (text.find("Lift to slip includes") != std::string::npos ? 1 : 0) +
           (text.find("Lift to slip is the slip onset") != std::string::npos ? 1 : 0);
  };
  EXPECT_EQ(explanations(labels.at("intervals").back().at("start_us").get<std::int64_t>() - 3'000), 2);
  EXPECT_EQ(explanations(nullptr), 0);
}

TEST_F(LabelCommand, PrintsOnsetsInSecondsSinceTheFirstEventOrInCameraTime) {
  ASSERT_EQ(run_tactile("label --no-pictures", folder.path()).exit_code, 0);
  const auto json = nlohmann::json::parse(run_tactile("label data/fan/01 --json", folder.path()).out).at("runs")[0];
  const double press_s = 1e-6 * json.at("intervals")[0].at("start_us").get<double>();
  const double first_s = 1e-6 * json.at("first_event_us").get<double>();
  ASSERT_GT(first_s, 1) << "otherwise both would look alike";
  for (const std::string command : {"label data/fan/01", "label data/fan/01 --summary"}) {
    const std::string since_first = run_tactile(command, folder.path()).out;
    const std::string camera = run_tactile(command + " --camera-time", folder.path()).out;
    EXPECT_NE(since_first.find(fmt::format("{:.4f} ±", press_s - first_s)), std::string::npos) << since_first;
    EXPECT_NE(camera.find(fmt::format("{:.4f} ±", press_s)), std::string::npos) << camera;
  }
}

TEST_F(LabelCommand, KeepsItsTablesWithinTheWidth) {
  const auto labelled = run_tactile("label --no-pictures --compare-truth", folder.path());
  ASSERT_EQ(labelled.exit_code, 0) << labelled.err;
  EXPECT_LE(longest_line_in(labelled.out), 80U) << labelled.out;
  EXPECT_NE(labelled.out.find("undamaged runs"), std::string::npos) << labelled.out;
  const auto summary = run_tactile("label --summary", folder.path());
  ASSERT_EQ(summary.exit_code, 0) << summary.err;
  EXPECT_LE(longest_line_in(summary.out), 80U) << summary.out;
  EXPECT_NE(summary.out.find("slip, events - robot"), std::string::npos) << summary.out;
}

TEST_F(LabelCommand, IsStrictOnceEverythingIsWritten) {
  leave_incomplete("data/fan/01");
  const auto result = run_tactile("label --strict --no-pictures", folder.path());
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_NE(result.out.find("was not completed"), std::string::npos) << result.out;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "data/usb-hub/01/labels.json"));
  EXPECT_EQ(run_tactile("label --strict --summary data/fan/01", folder.path()).exit_code, 2);
  EXPECT_EQ(run_tactile("label --summary data/fan/01", folder.path()).exit_code, 0);
  // A person looks at the flags and lifts them.
  const auto file = folder.path() / "data/fan/01/labels.json";
  auto labels = nlohmann::json::parse(read_text(file));
  for (auto& flag : labels.at("flags")) flag.at("confirmed") = true;
  write_whole(file, labels.dump());
  EXPECT_EQ(run_tactile("label --strict --summary data/fan/01", folder.path()).exit_code, 0);
}

TEST_F(LabelCommand, KeepsDamagedRunsApartInTheComparison) {
  std::filesystem::remove(folder.path() / "data/fan/01/robot.csv");
  leave_incomplete("data/fan/01");
  const auto result = run_tactile("label --compare-truth --json --no-pictures", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto flagged = nlohmann::json::parse(result.out).at("truth").at("flagged");
  EXPECT_EQ(flagged.at("damaged").at("runs"), 1);
  EXPECT_EQ(flagged.at("damaged").at("flagged"), 1);
  EXPECT_EQ(flagged.at("undamaged").at("runs"), 1);
}

TEST_F(LabelCommand, RefusesARegionThatIsNone) {
  for (const char* wrong :
       {"1,2,3", "1,2,3,4,5", "0,0,0,10", "-1,0,10,10", "a,b,c,d", "0,0,10,99999", "1,,2,3", "'0,0,10,10 '"}) {
    const auto result = run_tactile(std::string("label --no-pictures --roi=") + wrong, folder.path());
    EXPECT_NE(result.exit_code, 0) << wrong;
    EXPECT_NE(result.err.find("--roi"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("x,y,width,height"), std::string::npos) << result.err;
  }
  EXPECT_EQ(run_tactile("label --no-pictures --roi 10,20,300,200 data/fan/01", folder.path()).exit_code, 0);
  const auto larger = run_tactile("label --no-pictures --roi 10,20,8000,4000 data/fan/01", folder.path());
  EXPECT_EQ(larger.exit_code, 1);
  EXPECT_NE(larger.err.find("is not inside its frames"), std::string::npos) << larger.err;
}

TEST_F(LabelCommand, ReadsARobotLogWithoutHeaderByTheNamesThatAreGiven) {
  const auto file = folder / "data/fan/01/robot.csv";
  const auto labels = [&](const std::string& options) {
    const auto result = run_tactile("label data/fan/01 --no-pictures --json " + options, folder.path());
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out).at("runs").at(0);
  };
  const auto exported = [&] {
    EXPECT_EQ(run_tactile("label data/fan/01 --export out.json --format label-studio --force", folder.path()).exit_code, 0);
    return read_text(folder / "out.json");
  };
  const nlohmann::json expected = labels("");
  const std::string expected_export = exported();
  const std::string text = read_text(file);
  const std::size_t header = text.find('\n');
  write_whole(file, text.substr(header + 1), IfThere::replace);
  const auto refused = run_tactile("label data/fan/01 --no-pictures", folder.path());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("has no header; expected a header row with RTDE's names, or --robot-columns"), std::string::npos)
      << refused.err;
  EXPECT_EQ(labels("--robot-columns " + text.substr(0, header)).at("intervals"), expected.at("intervals"));
  EXPECT_EQ(exported(), expected_export);
  EXPECT_GE(run_tactile("label data/fan/01 --robot-columns 'a,,b'", folder.path()).exit_code, 100);
}

TEST_F(LabelCommand, RefusesAFormatThatNothingIsExchangedIn) {
  for (const std::string wrong : {"--format csv", "--origin camera"}) {
    const auto result = run_tactile("label " + wrong, folder.path());
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_NE(result.err.find("expected --export or --import too"), std::string::npos) << result.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "data/fan/01/labels.json"));
}

TEST_F(LabelCommand, NamesRunsThatHaveNoRecording) {
  std::filesystem::remove(folder.path() / "data/fan/01/events.aedat4");
  const auto result = run_tactile("label --no-pictures", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("left out, because events.aedat4 is missing: data/fan/01"), std::string::npos) << result.err;
}

TEST_F(LabelCommand, PrintsRemarksInTheSummary) {
  std::filesystem::remove(folder.path() / "data/fan/01/video.mp4");
  ASSERT_EQ(run_tactile("label --no-pictures", folder.path()).exit_code, 0);
  const auto summary = run_tactile("label --summary", folder.path());
  EXPECT_NE(summary.out.find("fan/01: no film"), std::string::npos) << summary.out;
  const auto runs = nlohmann::json::parse(run_tactile("label --summary --json", folder.path()).out).at("runs");
  EXPECT_FALSE(runs.at(0).at("remarks").empty());
}

}  // namespace
}  // namespace tactile::cli
