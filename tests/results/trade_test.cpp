#include "tactile/results/trade.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

Trade trade_in(const nlohmann::json& json) { return JsonView(json, "trade.json").get<Trade>(); }

GrowthPoint growth_at(double events_per_s) {
  return {.events_per_s = events_per_s,
          .history = 40ms,
          .sensor = {640, 480},
          .heatmap = {128, 96},
          .lit_share = 0.25,
          .sparse = {.rendering_us = 1, .network_us = 2, .p50_us = 3, .p99_us = 4},
          .dense = {.rendering_us = 5, .network_us = 6, .p50_us = 7, .p99_us = 8}};
}

/// With a value in every member.
Trade whole_trade() {
  Trade trade{.title = "title",
              .simulated = true,
              .times_are = "times",
              .judged_by = "judged",
              .settings = {{"seed", 3}},
              .software = {{"revision", "abc"}},
              .machine = {{"cpu", "a processor"}},
              .bootstrap = {.draws = 100, .confidence = 0.9, .seed = 7},
              .dataset = {.file = "../data/dataset.h5", .manifest_hash = "1f", .settings = {{"mix", false}}, .samples = 11},
              .runs = {{.train = {"fan/01"}, .choice = {"fan/02"}, .reported = {"fan/03"}},
                       {.train = {"fan/02"}, .choice = {"fan/03"}, .reported = {"fan/01"}}},
              .usual = "th40",
              .usual_is = "on the front",
              .interrupted = 0.125,
              .busy = 2,
              .left_out = {{30ms, 20ms, "no whole number"}},
              .not_measured = {{"int8", "the budget was used up"}},
              .unfinished = "The budget ended the work.",
              .growth = CostGrowth{{growth_at(0), growth_at(1e6)}, {growth_at(1)}, {growth_at(2)}},
              .steps = {{.name = "times", .command = "tactile trade", .seconds = 1.5, .finished_at = "2026-01-02T03:04:05Z"}}};
  trade.points.push_back({.id = "th40", .text = "as usual", .design = "usual", .models = {"a", "b"}, .trainings = 2});
  trade.points.back().values.th_ms = trade.points.back().values.tick_ms = trade.points.back().values.factor = 1;
  MeasuredAgain again{.model = "a", .trainings = 2, .runs = {"fan/03"}};
  again.result.figures.accuracy = {.value = 0.9, .low = 0.8, .high = 0.95, .n = 9, .trainings = 2};
  again.result.episodes = 4;
  again.result.figures.interrupted = 0.25;
  trade.recommendation = {.wish = {{"at_most_us", 200}},
                          .id = "th40",
                          .setting = trade.points.back().values,
                          .model = "a",
                          .met = true,
                          .chosen_in_interval = false,
                          .again = again,
                          .trial = {{"ticks", 5}},
                          .sentence = "Use it."};
  return trade;
}

TEST(Trade, ComesBackAsItWasWritten) {
  const nlohmann::json json = whole_trade();
  for (const auto& [key, value] : json.items()) EXPECT_FALSE(value.is_null()) << key << " is not in this test";
  for (const auto& [key, value] : json.at("recommendation").items()) EXPECT_FALSE(value.is_null()) << key;
  const Trade read = trade_in(json);
  EXPECT_EQ(nlohmann::json(read), json);
  EXPECT_EQ(read.cpu(), "a processor");
  EXPECT_EQ(read.left_out.at(0).tick, 20ms);
  ASSERT_TRUE(read.recommendation.again);
  EXPECT_EQ(read.recommendation.again->result.figures.accuracy.high, 0.95);
  EXPECT_EQ(read.recommendation.again->result.figures.interrupted, 0.25);
  EXPECT_EQ(read.interrupted, 0.125);
  // The runs of the first training are there twice: earlier versions had one training.
  EXPECT_EQ(json.at("runs").at("choice"), json.at("runs").at("trainings").at(0).at("choice"));
}

TEST(Trade, WithoutConstraintsAndGrowthHasNullsInTheirPlaces) {
  Trade trade = whole_trade();
  trade.growth.reset();
  trade.unfinished.clear();
  trade.recommendation = {.sentence = "No constraint given."};
  const nlohmann::json json = trade;
  for (const char* key : {"growth", "unfinished"}) EXPECT_TRUE(json.at(key).is_null()) << key;
  const nlohmann::json& recommendation = json.at("recommendation");
  for (const char* key : {"id", "setting", "chosen_in_interval", "again", "trial"})
    EXPECT_TRUE(recommendation.at(key).is_null()) << key;
  EXPECT_FALSE(recommendation.contains("model"));
  EXPECT_EQ(nlohmann::json(trade_in(json)), json);
}

TEST(Trade, OfAnEarlierVersionIsReadAsFarAsItGoes) {
  const Trade trade = trade_in({{"format", trade_format}, {"points", {{{"text", "as usual"}}}}});
  ASSERT_EQ(trade.points.size(), 1U);
  EXPECT_EQ(trade.points[0].values.kind, "lenet");
  EXPECT_FALSE(trade.growth);
  EXPECT_TRUE(trade.cpu().empty());
}

TEST(Trade, OfAnotherFormatOrTypeIsRefusedByFileAndMember) {
  EXPECT_EQ(test::error_of([] {
              trade_in({{"format", "tactile-trade-2"}});
            }),
            "trade.json: 'format' is another one; expected tactile-trade-1, as 'tactile trade' writes it");
  EXPECT_EQ(test::error_of([] {
              trade_in({{"format", trade_format}, {"recommendation", {{"again", {{"runs", 3}}}}}});
            }),
            "trade.json: 'recommendation': 'again': 'runs' is number; expected a list");
}

}  // namespace
}  // namespace tactile::results
