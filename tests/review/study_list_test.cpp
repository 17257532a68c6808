#include "tactile/review/study_list.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>

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

results::Claim claim_of_the_paper() {
  return {.id = "history-2-worst",
          .figure = "8",
          .paper = "2 ms is the worst history",
          .measure = "the number of objects with another",
          .unit = "objects",
          .is_below = true,
          .limit = 1,
          .written = 7,
          .replicates = 8,
          .measured = {.value = 0.5, .low = 0.25, .high = 0.75, .n = 8},
          .outcome = results::Outcome::holds};
}

TEST_F(StudyList, AStudyHasItsClaimsAndTheFiguresOfEachSetting) {
  const json figure = {{"value", 0.875}, {"low", 0.75}, {"high", nullptr}, {"n", 5}, {"trainings", 1}};
  const json accuracy = {{"mean", figure}, {"objects", json::object()}};
  const json decided = {{"alarms_per_min", {{"value", 2.5}, {"low", 2.0}, {"high", 3.0}, {"n", 8}}},
                        {"median_ms", {{"value", 4.0}, {"low", nullptr}, {"high", nullptr}, {"n", 8}}}};
  write("study", "study",
        {{"format", "tactile-study-2"},
         {"title", "A study of <b>"},
         {"simulated", true},
         {"steps",
          {{{"name", "train"}, {"finished_at", "2026-01-02T03:04:05Z"}},
           {{"name", "data"}, {"finished_at", "2026-01-01T00:00:00Z"}}}},
         {"claims", {claim_of_the_paper()}},
         {"results",
          {{{"setting", "th040"}, {"text", "LeNet, t_h 40 ms"}, {"th_ms", 40}, {"accuracy", accuracy}},
           {{"setting", "stream"},
            {"text", "stream"},
            {"accuracy", accuracy},
            {"whole_runs", {{"runs", {"fan/02"}}, {"decided", decided}}}}}}});
  const json list = studies_json(folder.path(), folder / "models");
  ASSERT_EQ(list.size(), 1U);
  const json& study = list.at(0);
  EXPECT_EQ(study.at("error"), nullptr) << study;
  EXPECT_EQ(study.at("name"), "study");
  EXPECT_EQ(study.at("kind"), "study");
  EXPECT_EQ(study.at("title"), "A study of <b>");
  EXPECT_EQ(study.at("when"), "2026-01-02T03:04:05Z");
  const json& claim = study.at("claims").at(0);
  EXPECT_EQ(claim.at("id"), "history-2-worst");
  EXPECT_EQ(claim.at("claim"), "2 ms is the worst history");
  EXPECT_EQ(claim.at("outcome"), "holds");
  EXPECT_EQ(claim.at("in_words"), results::words_of(claim_of_the_paper()));
  EXPECT_EQ(claim.at("unit"), "objects");
  EXPECT_EQ(claim.at("measured").at("low"), 0.25);
  const auto entry = [](const char* label, double value, json low, json high, const char* unit) {
    return json{{"label", label}, {"value", value}, {"low", std::move(low)}, {"high", std::move(high)}, {"unit", unit}};
  };
  EXPECT_EQ(study.at("figures"), json::array({entry("LeNet, t_h 40 ms: accuracy", 87.5, 75.0, nullptr, "%"),
                                              entry("stream: accuracy", 87.5, 75.0, nullptr, "%"),
                                              entry("stream: false alarms", 2.5, 2.0, 3.0, "1/min"),
                                              entry("stream: median delay", 4.0, nullptr, nullptr, "ms")}));
}

TEST_F(StudyList, AStudyOfAnotherFormatHasAnErrorAndItsName) {
  write("old", "study", {{"format", "tactile-study-1"}, {"title", "Of yesterday"}});
  const json list = studies_json(folder.path(), folder / "models");
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list.at(0).at("name"), "old");
  EXPECT_NE(list.at(0).at("error").get<std::string>().find("expected tactile-study-2"), std::string::npos);
  EXPECT_TRUE(list.at(0).at("figures").empty());
}

TEST_F(StudyList, ATradeHasItsSettings) {
  const auto figure = [](double value) {
    return json{{"value", value}, {"low", value - 1}, {"high", value + 1}, {"n", 5}, {"trainings", 1}};
  };
  write("fast", "trade",
        {{"format", "tactile-trade-2"},
         {"title", "Speed"},
         {"points", {{{"text", "as usual"}, {"reported", {{"accuracy", {{"value", 0.5}}}, {"us_p99", figure(120)}}}}}},
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
  write(".", "trade", {{"format", "tactile-trade-2"}, {"title", "Speed"}, {"points", json::array()}});
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
