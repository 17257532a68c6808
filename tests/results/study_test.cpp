#include "tactile/results/study.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

TrainedModel a_model() {
  return {.training = 1,
          .seed = 2,
          .history_ms = 2.5,
          .name = "m",
          .folder = "models/m",
          .history = "models/m/history.csv",
          .samples = "samples/m.json",
          .weights_sha256 = "ff"};
}

UnseenComparison a_comparison() {
  const SeenAndHeldOut fan{{.value = 0.75}, {.value = 0.5}, {.value = -0.25}};
  return {{}, {"fan/02"}, fan, {{"fan", fan}}};
}

/// Every member has a value of its own.
Study a_study() {
  TrainedModel judged = a_model();
  judged.accuracy = Figure{.value = 0.875, .low = 0.75, .high = 0.9375, .n = 3};
  const Accuracy accuracy{*judged.accuracy, {{"fan", *judged.accuracy}}};
  Study study{
      .title = "A study",
      .simulated = true,
      .settings = {{"data", "data"}},
      .software = {{"name", "tactile"}},
      .machine = {{"cores", 2}},
      .bootstrap = {{.draws = 100, .confidence = 0.9, .seed = 3}, "One training each."},
      .steps = {{.name = "train", .command = "tactile train", .seconds = 1.5, .finished_at = "2026-01-02T03:04:05Z"}},
      .dataset = {.file = "data.h5", .manifest_hash = "ab", .samples = 12, .tick_ms = 2, .guard_ms = 100},
      .trainings = {{.seed = 2,
                     .train_run = "01",
                     .history_ms = 2.5,
                     .train = {"fan/01"},
                     .choice = {"fan/03"},
                     .reported = {"fan/02"},
                     .all_test = {"fan/02", "fan/03"}}},
      .histories = {{.history_ms = 2.5, .models = {judged}, .accuracy = {.reported = accuracy, .all_test = accuracy}}},
      .choice = {{2.5, "m", "It is the best."}, "choice", {2.5, 40}, {}},
      .paper_way = {40, "n", "As in the paper."},
      .variance = VarianceShares{0.5, 0.25, 0.25},
      .training_spread = {.history_ms = 2.5, .mean = {0.75, 0.5}, .objects = {{"fan", {0.75, 0.5}}}},
      .evaluations = {{.id = "reported",
                       .models = {a_model()},
                       .runs = "reported",
                       .json_file = "e.json",
                       .csv_file = "e.csv",
                       .figures = {{"accuracy", accuracy}, {"confusion", {1, 2}}},
                       .slip_at_once = {{"fan", true}}}},
      .full_runs = {{.run = "fan/02", .model = "m", .history_ms = 2.5, .csv = "runs/fan-02.csv"}},
      .unseen = StudyUnseen{.held_out = {{"fan"}, {"jar", "mug"}},
                            .models = {"m", "u"},
                            .trainings = {a_model()},
                            .on = {.reported = a_comparison()}},
      .splits =
          {{.name = "split-007", .held_out = {"fan"}, .model = "m", .training = a_model(), .on = {.all_test = a_comparison()}}},
      .splits_mean = {.reported = Figure{.value = -0.25}},
      .remarks = {"A remark."},
      .left_out = {{"fan/04", "press-1", "flagged"}},
      .claims = {Claim{}},
      .found = {"It was found."},
      .summary = "A summary."};
  study.choice.best.reported = HistoryChoice{
      .history = microseconds{2500}, .of_objects = {{"fan", microseconds{2500}}}, .counts = {{microseconds{2500}, 1}, {40ms, 0}}};
  study.claims.front().id = "history-2-worst";
  study.claims.front().limit = 0;
  study.claims.front().all_test = ClaimOutcome{.in_words = "2 ms is the worst."};
  return study;
}

Study study_in(const nlohmann::json& json) { return JsonView(json, "study.json").get<Study>(); }

TEST(Study, IsReadAsWritten) {
  const nlohmann::json json = a_study();
  const Study read = study_in(json);
  EXPECT_EQ(nlohmann::json(read), json);
  EXPECT_EQ(read.bootstrap.draws, 100U);
  EXPECT_EQ(read.trainings.at(0).all_test.at(1), "fan/03");
  EXPECT_EQ(read.histories.at(0).models.at(0).accuracy->low, 0.75);
  EXPECT_EQ(read.choice.trainings, (std::vector<double>{2.5, 40}));
  EXPECT_EQ(read.choice.best.reported->counts.at(microseconds{2500}), 1U);
  EXPECT_EQ(read.paper_way.model, "n");
  EXPECT_EQ(read.training_spread.objects.at("fan").at(1), 0.5);
  EXPECT_EQ(read.unseen->held_out.at(1), (std::vector<std::string>{"jar", "mug"}));
  EXPECT_EQ(read.unseen->on.reported->objects.at("fan").difference.value, -0.25);
  EXPECT_EQ(read.splits.at(0).training->seed, 2U);
  EXPECT_EQ(read.left_out.at(0).what, "press-1");
}

TEST(Study, HasNullWhereNothingWasMeasured) {
  const nlohmann::json json = a_study(), empty = Study{};
  EXPECT_EQ(json.at("choice").at("best").at("choice"), nullptr);
  EXPECT_EQ(json.at("unseen").at("all_test"), nullptr);
  EXPECT_FALSE(json.at("unseen").contains("choice"));
  EXPECT_FALSE(json.at("unseen").at("trainings").at(0).contains("accuracy"));
  EXPECT_EQ(json.at("splits_mean"), (nlohmann::json{{"reported", Figure{.value = -0.25}}, {"all_test", nullptr}}));
  for (const char* key : {"variance", "training_spread", "unseen", "splits_mean"}) EXPECT_EQ(empty.at(key), nullptr) << key;
  EXPECT_EQ(empty.at("evaluations"), nlohmann::json::array());
}

TEST(Study, HistoriesAreInMilliseconds) {
  const nlohmann::json best = nlohmann::json(a_study()).at("choice").at("best").at("reported");
  EXPECT_EQ(best, (nlohmann::json{{"th_ms", 2.5}, {"objects", {{"fan", 2.5}}}, {"counts", {{"2.5", 1}, {"40", 0}}}}));
}

TEST(Study, OfAnEarlierVersionIsRead) {
  const Study study = study_in(
      {{"format", "tactile-study-1"},
       {"unseen", {{"held_out", {"fan", "jar"}}, {"models", {{"seen", "m"}, {"held_out", "u"}}}}},
       {"splits", {{{"name", "split-001"}, {"model", "m"}}}},
       {"evaluations", {{{"id", "reported"}, {"th_ms", 40}, {"model", "m"}, {"runs", "reported"}, {"json", "e.json"}}}}});
  EXPECT_EQ(study.unseen->held_out, (std::vector<std::vector<std::string>>{{"fan", "jar"}}));
  EXPECT_FALSE(study.splits.at(0).training);
  ASSERT_EQ(study.evaluations.at(0).models.size(), 1U);
  EXPECT_EQ(study.evaluations.at(0).models.at(0).name, "m");
  EXPECT_EQ(study.evaluations.at(0).models.at(0).history_ms, 40);
  EXPECT_TRUE(study.claims.empty());
  EXPECT_TRUE(study.machine.is_null());
}

TEST(Study, WhatIsOfAWrongTypeIsNamed) {
  const nlohmann::json json = a_study();
  const auto error_with = [&](const char* pointer, const nlohmann::json& value) {
    nlohmann::json changed = json;
    changed[nlohmann::json::json_pointer(pointer)] = value;
    return test::error_of([&] { study_in(changed); });
  };
  EXPECT_EQ(error_with("/dataset/samples", "many"), "study.json: 'dataset': 'samples' is string; expected a whole number from 0");
  EXPECT_EQ(error_with("/choice/best/reported/counts/few", 1U),
            "study.json: 'choice': 'best': 'reported': 'counts' has the key 'few'; expected a history in ms");
  EXPECT_EQ(error_with("/histories", 3), "study.json: 'histories' is number; expected a list");
  EXPECT_EQ(error_with("/format", "another"), "study.json: is of format 'another'; expected 'tactile-study-1'");
}

}  // namespace
}  // namespace tactile::results
