#include "tactile/results/cost_growth.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

CostGrowth growth_in(const nlohmann::json& json) { return JsonView(json, "trade.json").get<CostGrowth>(); }

TEST(CostGrowth, ComesBackAsItWasWritten) {
  CostGrowth growth;
  growth.by_rate.push_back({.events_per_s = 3e5,
                            .history = 2500us,
                            .sensor = {640, 480},
                            .heatmap = {64, 48},
                            .lit_share = 0.25,
                            .sparse = {1, 2, 3, 4},
                            .dense = {5, 6, 7, 8}});
  growth.by_resolution.resize(2);
  const nlohmann::json json = growth;
  EXPECT_EQ(json.at("rate").at(0).at("th_ms"), 2.5);
  const CostGrowth read = growth_in(json);
  ASSERT_EQ(read.by_rate.size(), 1U);
  EXPECT_EQ(read.by_rate[0].history, 2500us);
  EXPECT_EQ(read.by_rate[0].sensor, (events::SensorSize{640, 480}));
  EXPECT_EQ(read.by_rate[0].dense.p99_us, 8);
  EXPECT_EQ(read.by_resolution.size(), 2U);
  EXPECT_EQ(nlohmann::json(read), json);
}

TEST(CostGrowth, MayLackWhatWasNotMeasured) {
  EXPECT_TRUE(growth_in(nullptr).by_rate.empty());
  const GrowthPoint point = growth_in({{"rate", {{{"events_per_s", 1}}}}}).by_rate.at(0);
  EXPECT_EQ(point.sensor, events::SensorSize{});
  EXPECT_TRUE(std::isnan(point.sparse.p50_us));
}

TEST(CostGrowth, IsRefusedByFileAndMember) {
  EXPECT_EQ(test::error_of([] {
              growth_in({{"rate", {{{"th_ms", "x"}}}}});
            }),
            "trade.json: 'rate': 'th_ms' is string; expected a number");
}

}  // namespace
}  // namespace tactile::results
