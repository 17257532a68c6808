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

TEST(FalseAlarms, OfARunAreReadBackAndWrittenInThreeForms) {
  FalseAlarms alarms{.alarms = 1,
                     .after_intervals = 2,
                     .none_time = 20s,
                     .outside_labels = 3,
                     .outside_labels_time = 40s,
                     .outside_motion = 2,
                     .outside_motion_time = 24s,
                     .none_in_alarm = 500ms,
                     .wrong_class = 4,
                     .labelled_time = 10s};
  const nlohmann::json json = alarms;
  EXPECT_EQ(json.at("outside_labels"), 3);
  const FalseAlarms read = JsonView(json, "run.json").get<FalseAlarms>();
  EXPECT_EQ(nlohmann::json(read), json);
  EXPECT_EQ(words_of(read),
            "False alarms outside labels: 3 (4.5 per minute); without unlabelled motion: 2 (5.0 per minute); 2.5 % of none time "
            "in alarm. Episodes of the wrong class: 4 (24.0 per minute).");
  alarms.outside_motion_time = 0s;
  EXPECT_EQ(words_of(alarms),
            "False alarms outside labels: 3 (4.5 per minute); 2.5 % of none time in alarm. Episodes of the wrong class: 4 (24.0 "
            "per minute).")
      << "the run's true motion is not known";
}

TEST(FalseAlarms, OfAnOlderFileHaveNoRates) {
  const nlohmann::json json{{"count", 1U}, {"outside_labels", 3U}, {"wrong_class", 4U}};
  EXPECT_EQ(words_of(JsonView(json, "run.json").get<FalseAlarms>()),
            "False alarms outside labels: 3. Episodes of the wrong class: 4.");
}

}  // namespace
}  // namespace tactile::results
