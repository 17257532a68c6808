#include "tactile/results/false_alarm_table.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace tactile::results {
namespace {

TEST(FalseAlarmTable, IsReadBackAsItIsWritten) {
  const FalseAlarmTable table{.per_min = {2, 1, 3, 5},
                              .objects = {{"fan", {.value = 4}}},
                              .total = {.alarms = 6,
                                        .after_intervals = 2,
                                        .unlabelled = 1,
                                        .none_time = 180'000'001us,
                                        .after_intervals_time = 7us,
                                        .unlabelled_time = 0us}};
  const nlohmann::json json = table;
  EXPECT_EQ(json.at("count"), 6);
  EXPECT_EQ(json.at("after_intervals").at("count"), 2);
  const FalseAlarmTable read = JsonView(json, "eval.json").get<FalseAlarmTable>();
  EXPECT_EQ(read.total.none_time, 180'000'001us);
  EXPECT_EQ(nlohmann::json(read), json);
}

}  // namespace
}  // namespace tactile::results
