#include "tactile/results/trade.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/error_of.hpp"
#include "tactile/results/experiment_file.hpp"

namespace tactile::results {
namespace {

Trade trade_in(const nlohmann::json& json) { return experiment_in<Trade>(JsonView(json, "trade.json")); }

TradedSetting usual_setting() {
  TradedSetting setting{.id = "th40", .text = "as usual", .design = "usual", .models = {"a", "b"}, .trainings = 2};
  setting.values = {.kind = "stream",
                    .th_ms = 20,
                    .tick_ms = 2,
                    .factor = 0.1,
                    .resize = "area",
                    .denoise = "mean",
                    .engine = "fast",
                    .precision = "int8",
                    .augment = "flip"};
  setting.reported.accuracy = {.value = 0.9, .low = 0.8, .high = 0.95, .n = 9, .trainings = 2};
  setting.reported.whole_runs.p90_ms = {{.value = 30}, true};
  setting.reported.us_p99.value = 103;
  setting.reported.ticks = 114;
  setting.reported.interrupted = 0.25;
  setting.on_delay_front = true;
  setting.front_probability = {.accuracy = 0.25, .delay = 0.75};
  return setting;
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
              .interrupted = 0.125,
              .busy = 2,
              .points = {usual_setting()},
              .left_out = {{30ms, 20ms, "no whole number"}},
              .not_measured = {{"int8", "the budget was used up"}},
              .unfinished = "The budget ended the work.",
              .steps = {{.name = "times", .command = "tactile trade", .seconds = 1.5, .finished_at = "2026-01-02T03:04:05Z"}}};
  trade.recommendation = {.wish = {{"at_most_us", 200}},
                          .id = "th40",
                          .setting = trade.points.back().values,
                          .model = "a",
                          .met = true,
                          .chosen_in_interval = false,
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
  EXPECT_EQ(read.interrupted, 0.125);
  const TradedSetting& setting = read.points.at(0);
  EXPECT_EQ(setting.values.kind, "stream");
  EXPECT_EQ(setting.reported.accuracy.high, 0.95);
  EXPECT_TRUE(setting.reported.whole_runs.p90_ms.is_lower_bound);
  EXPECT_EQ(setting.reported.ticks, 114U);
  EXPECT_TRUE(setting.reported.is_disturbed());
  EXPECT_TRUE(std::isnan(setting.choice.us_p999.value)) << "nothing was timed";
  EXPECT_EQ(setting.front_probability.delay, 0.75);
}

TEST(Trade, WithoutConstraintsHasNoSetting) {
  Trade trade = whole_trade();
  trade.recommendation = {.sentence = "No constraint given."};
  trade.points.front().front_probability = {};
  const nlohmann::json json = trade;
  for (const char* key : {"setting", "chosen_in_interval", "trial"})
    EXPECT_TRUE(json.at("recommendation").at(key).is_null()) << key;
  EXPECT_EQ(json.at("recommendation").at("id"), "");
  EXPECT_EQ(nlohmann::json(trade_in(json)), json);
}

TEST(Trade, OfAnotherFormatOrTypeIsRefusedByFileAndMember) {
  const auto error = [](nlohmann::json json) { return test::error_of([&] { trade_in(json); }); };
  EXPECT_EQ(error({{"format", "tactile-trade-1"}}),
            "trade.json: 'format' is 'tactile-trade-1'; expected tactile-trade-2, as 'tactile trade' writes it into another "
            "folder");
  EXPECT_EQ(error({{"format", Trade().format}, {"points", {{{"reported", {{"us_p99", true}}}}}}}),
            "trade.json: 'points': 'reported': 'us_p99' is boolean; expected an object");
}

}  // namespace
}  // namespace tactile::results
