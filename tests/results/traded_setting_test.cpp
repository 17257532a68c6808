#include "tactile/results/traded_setting.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

TradedSetting setting_in(const nlohmann::json& json) { return JsonView(json, "trade.json").get<TradedSetting>(); }

/// Another value in every field, so that none takes the place of another.
TradeResult result_from(double first) {
  const auto figure = [&first] {
    first += 1;
    return Figure{.value = first, .low = first - 0.5, .high = first + 0.5, .n = 9, .trainings = 2};
  };
  const auto count = [&first] { return static_cast<std::uint64_t>(first += 1); };
  return {.figures = {.accuracy = figure(),
                      .us_p50 = figure(),
                      .us_p99 = figure(),
                      .us_p999 = figure(),
                      .delay_median_us = figure(),
                      .delay_p90_us = figure(),
                      .median_is_bound = false,
                      .p90_is_bound = true,
                      .missed = figure(),
                      .episodes_per_min = figure()},
          .delay_mean_us = figure(),
          .intervals = count(),
          .misses = count(),
          .early = count(),
          .episodes = count(),
          .ticks = count()};
}

TEST(TradedSetting, ComesBackAsItWasWritten) {
  TradedSetting setting{.id = "th20-stream",
                        .text = "stream",
                        .design = "one",
                        .values = {.kind = "stream",
                                   .th_ms = 20,
                                   .tick_ms = 2,
                                   .factor = 0.1,
                                   .resize = "area",
                                   .denoise = "mean",
                                   .engine = "fast",
                                   .precision = "int8",
                                   .pass = "dense",
                                   .confirm = "2/3",
                                   .augment = "flip"},
                        .models = {"a", "b"},
                        .trainings = 5,
                        .choice = result_from(0),
                        .reported = result_from(100)};
  setting.difference = TradeDifference{.accuracy = {.value = 1},
                                       .delay_us = {.value = 2},
                                       .missed = {.value = 3},
                                       .episodes_per_min = {.value = 4},
                                       .us_p50 = {.value = 5},
                                       .us_p99 = {.value = 6}};
  setting.on_delay_front = true;
  setting.front_probability = {.accuracy = 0.25, .delay = 0.75};
  const nlohmann::json json = setting;
  const TradedSetting read = setting_in(json);
  EXPECT_EQ(read.values.kind, "stream");
  EXPECT_EQ(read.reported.figures.us_p99.value, 103);
  EXPECT_EQ(read.reported.ticks, 114U);
  EXPECT_TRUE(read.choice.figures.p90_is_bound);
  EXPECT_TRUE(read.difference && read.difference->us_p99.value == 6);
  EXPECT_EQ(read.front_probability.delay, 0.75);
  EXPECT_EQ(nlohmann::json(read), json);
}

TEST(TradedSetting, OfAnEarlierVersionLacksWhatWasNotMeasured) {
  const TradedSetting usual = setting_in({{"text", "as usual"}, {"difference", nullptr}});
  EXPECT_EQ(usual.values.kind, "lenet");
  EXPECT_EQ(usual.values.augment, "none");
  EXPECT_FALSE(usual.difference);
  EXPECT_FALSE(usual.front_probability.accuracy);
  EXPECT_TRUE(std::isnan(usual.reported.figures.us_p999.value));
}

TEST(TradedSetting, IsRefusedByFileAndMember) {
  EXPECT_EQ(test::error_of([] {
              setting_in({{"reported", {{"us", {{"p99", "x"}}}}}});
            }),
            "trade.json: 'reported': 'us': 'p99' is string; expected an object");
}

}  // namespace
}  // namespace tactile::results
