#include "tactile/results/operating_point.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

TEST(OperatingPoint, ComesBackAsItWasWritten) {
  OperatingPoint point{.threshold = 0.9, .false_alarms_per_min = {.value = 4}, .false_alarms = 8};
  point.press = {.mean_ms = {.value = 6}, .intervals = 2, .misses = 1};
  const nlohmann::json json = point;
  EXPECT_EQ(json.at("delay_ms").at("press").at("misses"), 1);
  const auto read = JsonView(json, "eval.json", MissingMember::is_error).get<OperatingPoint>();
  EXPECT_EQ(read.threshold, 0.9);
  EXPECT_EQ(read.press.mean_ms.value, 6);
  EXPECT_EQ(read.false_alarms_per_min.value, 4);
  EXPECT_EQ(read.false_alarms, 8U);
  EXPECT_EQ(nlohmann::json(read), json);
}

TEST(OperatingPoint, IsRefusedByFileAndMember) {
  const nlohmann::json json = {{"delay_ms", {{"slip", {{"mean", "x"}}}}}};
  EXPECT_EQ(test::error_of([&] { JsonView(json, "eval.json").get<OperatingPoint>(); }),
            "eval.json: 'delay_ms': 'slip': 'mean' is string; expected an object");
}

}  // namespace
}  // namespace tactile::results
