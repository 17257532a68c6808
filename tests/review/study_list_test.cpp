#include "tactile/review/study_list.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/results/claim.hpp"
#include "tactile/results/evaluation.hpp"
#include "tactile/results/stress.hpp"

namespace tactile::review {
namespace {

using nlohmann::json;

class StudyList : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& kind, const json& document) const {
    std::filesystem::create_directories(folder / name);
    write_json(folder / name / (kind + ".json"), document);
  }
  test::TemporaryFolder folder;
};

TEST_F(StudyList, AStudyHasItsClaimsAndTheAccuracyOfEachHistory) {
  results::Claim claim;
  claim.id = "history-2-worst";
  claim.claim = "2 ms is the worst history";
  claim.unit = "points";
  claim.limit = 0;
  claim.measured = {.value = -3.5, .low = -5, .high = -2, .n = 5};
  claim.outcome = results::Outcome::holds;
  claim.in_words = "true for 5 of 5 objects";
  const json figure = {{"value", 0.875}, {"low", 0.75}, {"high", nullptr}, {"n", 5}, {"trainings", 1}};
  write("study", "study",
        {{"format", "tactile-study-1"},
         {"title", "A study of <b>"},
         {"simulated", true},
         {"steps",
          {{{"name", "train"}, {"finished_at", "2026-01-02T03:04:05Z"}},
           {{"name", "data"}, {"finished_at", "2026-01-01T00:00:00Z"}}}},
         {"claims", {claim}},
         {"histories", {{{"th_ms", 40}, {"accuracy", {{"reported", {{"mean", figure}, {"objects", json::object()}}}}}}}}});
  const json list = studies_json(folder.path(), folder / "models");
  ASSERT_EQ(list.size(), 1U);
  const json& study = list.at(0);
  EXPECT_EQ(study.at("error"), nullptr) << study;
  EXPECT_EQ(study.at("name"), "study");
  EXPECT_EQ(study.at("kind"), "study");
  EXPECT_EQ(study.at("title"), "A study of <b>");
  EXPECT_EQ(study.at("when"), "2026-01-02T03:04:05Z");
  EXPECT_EQ(study.at("claims").at(0).at("claim"), "2 ms is the worst history");
  EXPECT_EQ(study.at("claims").at(0).at("outcome"), "holds");
  EXPECT_EQ(study.at("claims").at(0).at("measured").at("low"), -5);
  const json& accuracy = study.at("figures").at(0);
  EXPECT_EQ(accuracy, (json{{"label", "Accuracy, t_h 40 ms"}, {"value", 87.5}, {"low", 75.0}, {"high", nullptr}, {"unit", "%"}}));
}

TEST_F(StudyList, ATradeHasItsSettings) {
  const auto figure = [](double value) {
    return json{{"value", value}, {"low", value - 1}, {"high", value + 1}, {"n", 5}, {"trainings", 1}};
  };
  write("fast", "trade",
        {{"format", "tactile-trade-1"},
         {"title", "Speed"},
         {"points", {{{"text", "as usual"}, {"reported", {{"accuracy", {{"value", 0.5}}}, {"us", {{"p99", figure(120)}}}}}}}},
         {"recommendation", {{"sentence", "Take t_h 20 ms."}}}});
  const json trade = studies_json(folder.path(), folder / "models").at(0);
  EXPECT_EQ(trade.at("error"), nullptr) << trade;
  EXPECT_EQ(trade.at("figures").at(0).at("value"), 50.0);
  EXPECT_EQ(trade.at("figures").at(0).at("low"), nullptr);
  EXPECT_EQ(trade.at("figures").at(1),
            (json{{"label", "as usual: time of a tick, p99"}, {"value", 120}, {"low", 119}, {"high", 121}, {"unit", "us"}}));
  EXPECT_EQ(trade.at("remarks"), json::array({"Take t_h 20 ms."}));
}

TEST_F(StudyList, AStressHasTheSeveritiesThatModelsHoldUpTo) {
  results::Stress stress;
  stress.title = "Worse";
  results::StressCurve curve;
  curve.name = "noise";
  curve.unit = "kev/s";
  curve.points = {{.severity = 0}, {.severity = 100}};
  curve.holds = results::HoldsUpTo{.severity = {.value = 100}, .is_beyond = true};
  stress.models = {{.name = "net", .trainings = {"net"}, .curves = {curve}}};
  write("worse", "stress", stress);
  const json read = studies_json(folder.path(), folder / "models").at(0);
  EXPECT_EQ(read.at("error"), nullptr) << read;
  EXPECT_EQ(read.at("figures").at(0).at("label"), "net, noise: holds up to");
  EXPECT_EQ(read.at("figures").at(0).at("unit"), "kev/s");
  EXPECT_EQ(read.at("figures").at(0).at("is_beyond"), true);
}

TEST_F(StudyList, AFolderThatIsAStudyItselfIsListed) {
  write(".", "trade", {{"format", "tactile-trade-1"}, {"title", "Speed"}, {"points", json::array()}});
  EXPECT_EQ(studies_json(folder.path(), folder / "models").at(0).at("name"), folder.path().filename().string());
  EXPECT_TRUE(studies_json(folder / "none", folder / "models").empty());
}

TEST_F(StudyList, TheEvaluationOfAModelIsListed) {
  results::Evaluation evaluation;
  evaluation.models.push_back({.name = "a", .settings = json::object(), .weights_sha256 = "", .test_runs = {"fan/02"}});
  evaluation.accuracy.mean = {.value = 0.875, .low = 0.75, .high = 1, .n = 5};
  evaluation.network.slip.all.median_of_all_ms.ms = {.value = 6, .low = 4, .high = 8, .n = 5};
  write("models/a", "model", json::object());
  write("models/a", "eval", evaluation);
  write("elsewhere", "eval", evaluation);
  const json list = studies_json(folder.path(), folder / "models");
  ASSERT_EQ(list.size(), 2U) << list;
  EXPECT_EQ(list.at(0).at("name"), "elsewhere");
  const json& entry = list.at(1);
  EXPECT_EQ(entry.at("error"), nullptr) << entry;
  EXPECT_EQ(entry.at("name"), "a");
  EXPECT_EQ(entry.at("kind"), "eval");
  EXPECT_EQ(entry.at("title"), results::title_of(evaluation));
  EXPECT_EQ(entry.at("figures").at(0),
            (json{{"label", "Accuracy"}, {"value", 87.5}, {"low", 75.0}, {"high", 100.0}, {"unit", "%"}}));
  const json delay{{"label", "Detection delay of slip, median"}, {"value", 6.0}, {"low", 4.0}, {"high", 8.0}, {"unit", "ms"}};
  EXPECT_EQ(std::count(entry.at("figures").begin(), entry.at("figures").end(), delay), 1) << entry;
}

}  // namespace
}  // namespace tactile::review
