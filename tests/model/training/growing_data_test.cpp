#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "model/small_data.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/model/training/dataset_bundle.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;
using test::make_runs;
using test::run_tactile;
using Names = std::vector<std::string>;

/// A command's result as JSON.
nlohmann::json result_of(const std::string& arguments, const fs::path& in) {
  const auto result = run_tactile(arguments + " --json --threads 1", in);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return nlohmann::json::parse(result.out);
}

const std::string train = "train --epochs 1";

TEST(GrowingData, GivesANewModelAndKeepsTheOlderOne) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto first = result_of(train, folder.path());
  const std::string name = first.at("name");
  const std::string older = sha256_of_file(folder / "models" / name / "model.json");

  make_runs(folder / "data", {"cup"}, 2);
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  const auto second = result_of(train, folder.path());
  EXPECT_EQ(second.at("outcome"), "trained");
  EXPECT_EQ(second.at("name"), name + "-2");
  EXPECT_EQ(second.at("train_runs"), nlohmann::json({"cup/01", "fan/01", "usb-hub/01"}));
  EXPECT_EQ(sha256_of_file(folder / "models" / name / "model.json"), older);
  EXPECT_EQ(result_of(train, folder.path()).at("outcome"), "unchanged");
  EXPECT_EQ(result_of(train + " --force", folder.path()).at("name"), name + "-2");

  test::make_run(folder / "data/cup/03", 5);
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  const auto third = run_tactile(train, folder.path());
  ASSERT_EQ(third.exit_code, 0) << third.err;
  EXPECT_NE(third.err.find(name + " learned from another state of data/dataset.h5"), std::string::npos) << third.err;
  EXPECT_TRUE(fs::exists(folder / "models" / (name + "-3") / "model.json"));

  // The dataset of last week again: its model is there.
  fs::remove_all(folder / "data/cup");
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  const auto again = result_of(train, folder.path());
  EXPECT_EQ(again.at("outcome"), "unchanged");
  EXPECT_EQ(again.at("name"), name);
}

TEST(GrowingData, IsJudgedByAnOlderModelExceptForTheRunsThatItLearnedFrom) {
  const test::TemporaryFolder folder;
  const fs::path data = folder / "data";
  make_runs(data, {"fan", "usb-hub"}, 2);
  const auto model = result_of(train, folder.path());
  const std::string then = windows::Dataset(data / "dataset.h5").manifest_hash();

  make_runs(data, {"cup"}, 1);
  test::make_run(data / "usb-hub/03", 7);
  fs::copy(data / "fan/01", data / "fan/03",
           fs::copy_options::recursive);  // a recording that it learned from, under another name and compressed otherwise
  const std::string copied = (data / "fan/03/events.aedat4").string();
  ASSERT_EQ(run_tactile("convert '" + (data / "fan/01/events.aedat4").string() + "' '" + copied + "' --compression zstd --force",
                        folder.path())
                .exit_code,
            0);
  ASSERT_NE(sha256_of_file(copied), sha256_of_file(data / "fan/01/events.aedat4"));
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  const auto judged = run_tactile("eval", folder.path());
  ASSERT_EQ(judged.exit_code, 0) << judged.err;
  std::string line = judged.out;
  std::replace(line.begin(), line.end(), '\n', ' ');
  const std::string name = model.at("name"), now = windows::Dataset(data / "dataset.h5").manifest_hash();
  EXPECT_NE(line.find("Learned from manifest " + then.substr(0, 8) + ". Judged on the 4 of 7 runs that it has not seen."),
            std::string::npos)
      << judged.out;
  EXPECT_LE(std::count(judged.out.begin(), judged.out.end(), '\n'), 22) << judged.out;

  // Every command shows this judgement, and says of which data it is.
  const auto listed = result_of("models", folder.path()).at("models").at(0);
  EXPECT_EQ(listed.at("trained").at("manifest_hash"), then);
  EXPECT_EQ(listed.at("eval").at("manifest_hash"), now);
  EXPECT_EQ(listed.at("eval").at("file"), "eval-on-" + now.substr(0, 8) + ".json");
  const std::string list = run_tactile("models", folder.path()).out;
  EXPECT_NE(list.find("*: judged on other data than it learned from"), std::string::npos) << list;
  EXPECT_EQ(list.find("  -  "), std::string::npos) << list;
  ASSERT_EQ(run_tactile("models pin " + name, folder.path()).exit_code, 0);
  const auto reported = run_tactile("report", folder.path());
  EXPECT_EQ(reported.exit_code, 0) << reported.err;
  EXPECT_NE(reported.err.find("reporting models/" + name + ", the pinned model"), std::string::npos) << reported.err;
  const std::string page = read_text(folder / "report/report.html");
  EXPECT_NE(page.find("learned from data/dataset.h5 with manifest " + then.substr(0, 8)), std::string::npos);
  EXPECT_EQ(page.find("was not evaluated"), std::string::npos);
  ASSERT_EQ(run_tactile("models unpin", folder.path()).exit_code, 0);

  // A judgement on another dataset file, though newer, does not take its place.
  fs::copy(data, folder / "other", fs::copy_options::recursive);
  fs::remove(folder / "other/dataset.h5");
  ASSERT_EQ(run_tactile("windows other --seed 5", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile("eval other", folder.path()).exit_code, 0);
  EXPECT_EQ(result_of("models", folder.path()).at("models").at(0).at("eval").at("manifest_hash"), now);

  const auto json = result_of("eval", folder.path());
  EXPECT_EQ(json.at("test_runs"), nlohmann::json({"cup/01", "fan/02", "usb-hub/02", "usb-hub/03"}));
  EXPECT_EQ(json.at("learned_from").at("dataset"), "data/dataset.h5");
  EXPECT_EQ(json.at("learned_from").at("manifest_hash"), then);
  EXPECT_EQ(json.at("learned_from").at("runs"), nlohmann::json({"fan/01", "usb-hub/01"}));
  EXPECT_EQ(json.at("learned_from").at("left_out"), nlohmann::json({"fan/01", "fan/03", "usb-hub/01"}));
  const fs::path results = folder / "models" / model.at("name").get<std::string>();
  EXPECT_FALSE(fs::exists(results / "eval.json"));
  EXPECT_TRUE(fs::exists(results / ("eval-on-" + windows::Dataset(data / "dataset.h5").manifest_hash().substr(0, 8) + ".json")));

  // Nor on runs that its temperature was fitted on.
  result_of(train + " --calibrate 02", folder.path());
  const std::string newer = model.at("name").get<std::string>() + "-2";
  EXPECT_EQ(result_of("eval --model " + newer, folder.path()).at("test_runs"), nlohmann::json({"usb-hub/03"}))
      << "fan/03 is the recording of fan/01";
  test::make_run(data / "cup/02", 9);
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  EXPECT_EQ(result_of("eval --model " + newer, folder.path()).at("test_runs"), nlohmann::json({"cup/02", "usb-hub/03"}));
}

TEST(GrowingData, OfObjectsThatAModelDidNotLearnFromIsItsTest) {
  const test::TemporaryFolder folder;
  make_runs(folder.path(), {"cup", "fan", "usb-hub"}, 2);
  windows::write_dataset(folder.path(), folder / "dataset.h5", {}, 1);
  const windows::Dataset dataset(folder / "dataset.h5");
  ModelDescription model;  // trained before there was a cup
  model.manifest_hash = std::string(64, '0');
  model.settings.split = {.kind = windows::SplitKind::unseen, .train_run = "01", .held_out = {"usb-hub"}};
  model.learned_from = {learned_run_of(dataset.runs()[2])};
  EXPECT_EQ(names_of(dataset, learned_runs_of(dataset, model)), Names{"fan/01"});
  EXPECT_EQ(names_of(dataset, test_runs_of(dataset, model)), (Names{"cup/01", "cup/02", "usb-hub/01", "usb-hub/02"}));
  model.settings.split.kind = windows::SplitKind::single_run;
  EXPECT_EQ(names_of(dataset, test_runs_of(dataset, model)), (Names{"cup/01", "cup/02", "fan/02", "usb-hub/01", "usb-hub/02"}));
  for (const windows::DatasetRun& run : dataset.runs()) model.learned_from.push_back(learned_run_of(run));
  EXPECT_THROW(test_runs_of(dataset, model), Error) << "it has seen all of them";
}

}  // namespace
}  // namespace tactile::model
