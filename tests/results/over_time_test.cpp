#include "tactile/results/over_time.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

TEST(AccuracyOverTime, ComesBackAsItWasWritten) {
  AccuracyOverTime accuracy;
  accuracy.all = {.first = {.value = 0.97}, .last_minus_before = {-0.1, -0.2, 0, 3}, .intervals = 20, .short_ones = 12};
  accuracy.objects["fan"].still_predicted.value = 0.4;
  accuracy.since_onset.push_back({.from = 50ms, .to = 100ms, .accuracy = {.value = 0.9}, .ticks = 25, .intervals = 3});
  const nlohmann::json json = accuracy;
  EXPECT_EQ(json.at("since_onset").at(0).at("from_ms"), 50.0);
  const auto read = JsonView(json, "eval.json", MissingMember::is_error).get<AccuracyOverTime>();
  EXPECT_EQ(read.all.last_minus_before.low, -0.2);
  EXPECT_EQ(read.all.short_ones, 12U);
  EXPECT_EQ(read.objects.at("fan").still_predicted.value, 0.4);
  ASSERT_EQ(read.since_onset.size(), 1U);
  EXPECT_EQ(read.since_onset[0].to, 100ms);
  EXPECT_EQ(read.since_onset[0].ticks, 25U);
  EXPECT_EQ(nlohmann::json(read), json);
}

TEST(AccuracyOverTime, IsReadFromFilesOfEarlierVersions) {
  const nlohmann::json json = {{"still_said", {{"value", 0.4}}}};
  EXPECT_EQ(JsonView(json, "eval.json").get<ShareOverTime>().still_predicted.value, 0.4);
}

TEST(AccuracyOverTime, IsRefusedByFileAndMember) {
  const nlohmann::json json = {{"before_end", {{{"to_ms", "x"}}}}};
  EXPECT_EQ(test::error_of([&] { JsonView(json, "eval.json").get<AccuracyOverTime>(); }),
            "eval.json: 'before_end': 'to_ms' is string; expected a number");
}

}  // namespace
}  // namespace tactile::results
