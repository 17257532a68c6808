#include "tactile/review/model_list.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/lenet_layers.hpp"
#include "tactile/results/evaluation.hpp"

namespace tactile::review {
namespace {

using nlohmann::json;

/// models/NAME: an untrained network for heatmaps of 32 x 24 cells.
model::ModelBundle make_bundle(const std::filesystem::path& models, const std::string& name, unsigned epochs) {
  model::ModelBundle bundle{models / name};
  model::ModelDescription description;
  description.input = {32, 24};
  description.dataset = "data/dataset.h5";
  description.manifest_hash = "abc";
  description.train_runs = {"fan/01"};
  description.trained_at = "2026-01-01T00:00:00Z";
  description.settings.training.epochs = epochs;
  model::Weights weights;
  for (const model::ParameterShape& shape : model::lenet_layers(description.input).parameters())
    weights.push_back({shape, std::vector<float>(shape.count(), 0.125F)});
  model::TrainingSummary summary;
  summary.history = {{1, 0.5, 0.75, {}, {}, 0.001, 2.5, 321.5, 1.0}, {2, 0.25, 0.875, {}, {}, 0.001, 2.5, 321.5, 1.0}};
  summary.best_epoch = 2;
  model::write_bundle(bundle, description, {weights, {}}, summary);
  return bundle;
}

TEST(ModelList, AModelHasItsOtherSettingsItsSizeAndItsTraining) {
  const test::TemporaryFolder folder;
  const unsigned usual = model::ModelSettings{}.training.epochs;
  make_bundle(folder.path(), "a", usual);
  make_bundle(folder.path(), "b", usual + 5);
  const json list = models_json(folder.path());
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list.at(0).at("error"), nullptr) << list;
  EXPECT_EQ(list.at(0).at("name"), "a");
  EXPECT_EQ(list.at(0).at("kind"), "lenet");
  EXPECT_EQ(list.at(0).at("settings"), (json{{"split", "single-run"}}));
  EXPECT_EQ(list.at(1).at("settings"), (json{{"split", "single-run"}, {"training.epochs", usual + 5}}));
  EXPECT_EQ(list.at(0).at("parameters"), model::lenet_layers({32, 24}).parameter_count());
  EXPECT_EQ(list.at(0).at("trained").at("runs"), json::array({"fan/01"}));
  EXPECT_EQ(list.at(0).at("history").size(), 2U);
  EXPECT_EQ(list.at(0).at("history").at(1).at("loss"), 0.25);
  EXPECT_EQ(list.at(0).at("eval"), nullptr);
}

TEST(ModelList, AnEvaluatedModelHasItsFigures) {
  const test::TemporaryFolder folder;
  const model::ModelBundle bundle = make_bundle(folder.path(), "a", 1);
  results::Evaluation evaluation;
  evaluation.models.push_back({.name = "a", .settings = json::object(), .weights_sha256 = "", .test_runs = {"fan/02"}});
  evaluation.accuracy.mean = {.value = 0.9, .low = 0.85, .high = 0.95, .n = 5};
  evaluation.network.press.all.median_of_all_ms.ms = {.value = 6, .low = 4, .high = 8, .n = 5};
  evaluation.whole_runs.decided.alarms_per_min = {.value = 2.5, .low = 1, .high = 4, .n = 5};
  write_json(bundle.evaluation(), evaluation);
  const json eval = models_json(folder.path()).at(0).at("eval");
  EXPECT_EQ(eval.at("accuracy"), (json{{"value", 0.9}, {"low", 0.85}, {"high", 0.95}}));
  EXPECT_EQ(eval.at("press_delay_ms"), (json{{"value", 6.0}, {"low", 4.0}, {"high", 8.0}}));
  EXPECT_EQ(eval.at("false_alarms_per_min").at("value"), 2.5);
  EXPECT_EQ(eval.at("slip_delay_ms").at("value"), nullptr);  // it was not measured
}

TEST(ModelList, WithoutAFolderIsEmpty) { EXPECT_EQ(models_json("/nowhere/at/all"), json::array()); }

}  // namespace
}  // namespace tactile::review
