#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "support/run_command.hpp"
#include "support/settings_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/whole_runs.hpp"

namespace tactile::stress {
namespace {

namespace fs = std::filesystem;

test::CommandResult run_in(const fs::path& folder, const std::string& command) {
  auto result = test::run_tactile(command + " --threads 2", folder);
  EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.err;
  return result;
}

/// Three objects of two simulated runs, and a model of one epoch.
void make_model(const fs::path& folder) {
  run_in(folder, "simulate --preset tiny --objects fan,small-box,water-bottle");
  run_in(folder, "label --no-pictures");
  run_in(folder, "windows");
  run_in(folder, "train --epochs 2");
}

nlohmann::json stressed(const fs::path& folder, const std::string& arguments) {
  return nlohmann::json::parse(run_in(folder, "stress " + arguments + " --json").out, nullptr, false);
}

TEST(StressCommand, JudgesWorsenedRunsAsEvalDoesAndResumes) {
  const test::TemporaryFolder folder;
  make_model(folder.path());
  const std::string arguments =
      "--recipe loss:20,95 --recipe noise:100 --world light-dim:90 --quiet-recording data/small-box/01/events.aedat4 ";
  const auto dry_run = [&] { return stressed(folder.path(), arguments + "--dry-run"); };
  for (const auto& part : dry_run().at("parts")) EXPECT_EQ(part.at("exist"), 0) << part;
  EXPECT_FALSE(fs::exists(folder / "stress"));
  const nlohmann::json stress = stressed(folder.path(), arguments);
  ASSERT_TRUE(stress.is_object());
  for (const auto& part : dry_run().at("parts")) EXPECT_EQ(part.at("exist"), part.at("count")) << part;
  EXPECT_EQ(stress.at("simulated"), true);
  const nlohmann::json& model = stress.at("models")[0];
  ASSERT_EQ(model.at("curves").size(), 3U);
  const nlohmann::json &loss = model.at("curves")[0], &clean = loss.at("points")[0];
  ASSERT_EQ(loss.at("points").size(), 3U);
  EXPECT_EQ(clean.at("severity"), 0);

  // The unchanged runs are those of eval, to the last digit.
  run_in(folder.path(), "eval");
  const nlohmann::json eval = read_json(folder / "models" / model.at("name").get<std::string>() / "eval.json");
  EXPECT_EQ(clean.at("accuracy"), eval.at("accuracy").at("mean"));
  EXPECT_EQ(clean.at("whole"), eval.at("whole_runs").at("decided"));
  EXPECT_EQ(model.at("runs"), eval.at("whole_runs").at("runs"));

  EXPECT_NE(loss.at("points")[2].at("accuracy"), clean.at("accuracy")) << "a twentieth of the events";
  EXPECT_EQ(model.at("curves")[2].at("is_world"), true);
  ASSERT_EQ(model.at("quiet").size(), 2U) << "recipes, not worlds";
  EXPECT_GT(model.at("quiet")[0].at("points")[0].at("whole").at("outside_min").get<double>(), 0);

  const std::string csv = read_text(folder / "stress" / "stress.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 3 + 2 + 2 + 3 + 2);
  for (const char* figure : {"stress-accuracy.svg", "stress-detected.png", "stress-false-alarms.svg", "stress-quiet.png"})
    EXPECT_TRUE(fs::exists(folder / "stress" / "figures" / figure)) << figure;

  for (const char* recipe : {"loss", "noise"})
    EXPECT_TRUE(fs::exists(folder / "stress" / "recipes" / (std::string(recipe) + ".png"))) << recipe;

  // Nothing is done again; what is removed is.
  const nlohmann::json again = stressed(folder.path(), arguments);
  EXPECT_EQ(again.at("steps_done"), 0);
  EXPECT_EQ(again.at("models"), stress.at("models"));
  fs::remove(folder / "stress" / "judged" / (model.at("name").get<std::string>() + "-loss-95.csv"));
  const nlohmann::json resumed = stressed(folder.path(), arguments);
  EXPECT_EQ(resumed.at("steps_done"), 1);
  EXPECT_EQ(resumed.at("models"), stress.at("models"));

  const auto brief = run_in(folder.path(), "stress " + arguments);
  EXPECT_LE(std::count(brief.out.begin(), brief.out.end(), '\n'), 15) << brief.out;
  EXPECT_LT(brief.out.find("\nloss "), brief.out.find("\nnoise ")) << "what harms most comes first\n" << brief.out;
  EXPECT_NE(run_in(folder.path(), "stress " + arguments + " --verbose").out.find("quiet, unchanged"), std::string::npos);

  test::expect_settings_of("stress/settings.json", "stress " + arguments, folder.path());

  run_in(folder.path(), "report stress");
  const std::string page = read_text(folder / "stress" / "report" / "report.html");
  EXPECT_NE(page.find("When the scene gets worse"), std::string::npos);
  EXPECT_NE(page.find("figure-stress-accuracy"), std::string::npos);
}

TEST(StressCommand, SaysWhatIsWrongInOneSentence) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder / "data");
  const auto wrong = test::run_tactile("stress --recipe nois --quiet-recording none.aedat4", folder.path());
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_EQ(std::count(wrong.err.begin(), wrong.err.end(), '\n'), 1) << wrong.err;
}

}  // namespace
}  // namespace tactile::stress
