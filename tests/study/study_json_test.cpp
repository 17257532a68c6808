#include "tactile/study/study_json.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"

namespace tactile {
namespace {

TEST(StudyJson, DetectionsComeBackAsTheyWereWritten) {
  Detection late, missed;
  late.interval = {Touch::slip, camera_time(1'700'000'000'000'001), camera_time(1'700'000'000'400'000)};
  late.outcome = DetectionOutcome::detected;
  late.delay = 6ms;
  missed.interval = {Touch::press, camera_time(5), camera_time(7)};
  nlohmann::json evaluation = {{"runs", {{{"object", "fan"}, {"intervals", {late, missed}}}}}};
  const auto runs = detections_in(evaluation, "eval.json");
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0].object, "fan");
  ASSERT_EQ(runs[0].detections.size(), 2U);
  EXPECT_EQ(runs[0].detections[0].interval.start, late.interval.start);
  EXPECT_EQ(runs[0].detections[0].delay, 6ms);
  EXPECT_EQ(runs[0].detections[1].outcome, DetectionOutcome::missed);
  evaluation.at("runs")[0].at("intervals")[1].at("outcome") = "late";
  EXPECT_EQ(test::error_of([&] { detections_in(evaluation, "eval.json"); }),
            "eval.json: 'runs': 'intervals': 'outcome' is 'late'; expected detected, missed or early");
}

TEST(StudyJson, ToldAtOnceIsWithoutAnyDelayMissOrEarlyOne) {
  const auto at_once = told_at_once({{"a", {.mean_ms = {.value = 2}, .intervals = 2}},
                                     {"b", {.mean_ms = {.value = 2}, .intervals = 2, .misses = 1}},
                                     {"c", {.mean_ms = {.value = 3}, .intervals = 2}}},
                                    2);
  EXPECT_TRUE(at_once.at("a"));
  EXPECT_FALSE(at_once.at("b"));
  EXPECT_FALSE(at_once.at("c"));
}

TEST(StudyJson, TablesHaveARowForEachFigure) {
  Accuracy accuracy;
  accuracy.mean = {0.5, 0.25, 0.75, 3};
  accuracy.objects["fan"] = {0.25, {}, {}, 1};
  EXPECT_EQ(accuracy_csv({{2.5, "reported", &accuracy}}),
            "th_ms,runs,object,value,low,high,n\n"
            "2.5,reported,all,0.5,0.25,0.75,3\n"
            "2.5,reported,fan,0.25,,,1\n");
  UnseenComparison comparison;
  comparison.mean.seen = accuracy.mean;
  comparison.objects["fan"].held_out = accuracy.objects.at("fan");
  EXPECT_EQ(unseen_csv({{"paper", "reported", comparison}}),
            "split,runs,object,of,value,low,high,n\n"
            "paper,reported,all,seen,0.5,0.25,0.75,3\n"
            "paper,reported,fan,seen,,,,0\n"
            "paper,reported,all,held_out,,,,0\n"
            "paper,reported,fan,held_out,0.25,,,1\n"
            "paper,reported,all,difference,,,,0\n"
            "paper,reported,fan,difference,,,,0\n");
  Claim claim;
  claim.id = "x";
  claim.unit = "ms";
  claim.asked = Asked::below;
  claim.limit = 5;
  claim.kept = 4;
  claim.of = 6;
  claim.measured = {3, 2, 4, 3};
  claim.verdict = Verdict::holds;
  EXPECT_EQ(claims_csv({claim}),
            "id,runs,value,low,high,n,unit,asked,limit,kept,of,verdict\nx,reported,3.0,2.0,4.0,3,ms,below,5,4,6,holds\n");
}

}  // namespace
}  // namespace tactile
