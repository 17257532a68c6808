#include "tactile/experiments/study/study_tables.hpp"

#include <gtest/gtest.h>

namespace tactile::study {
namespace {

TEST(StudyTables, HaveARowForEachFigure) {
  results::Accuracy accuracy;
  accuracy.mean = {0.5, 0.25, 0.75, 3};
  accuracy.objects["fan"] = {0.25, {}, {}, 1};
  results::StudyHistory history{.history_ms = 2.5};
  history.accuracy.reported = accuracy;
  EXPECT_EQ(accuracy_csv({history}),
            "th_ms,runs,object,value,low,high,n\n"
            "2.5,reported,all,0.5,0.25,0.75,3\n"
            "2.5,reported,fan,0.25,,,1\n");
  results::UnseenComparison comparison;
  comparison.mean.seen = accuracy.mean;
  comparison.objects["fan"].held_out = accuracy.objects.at("fan");
  results::Study study;
  study.unseen.emplace().on.reported = comparison;
  study.splits = {{.name = "split-007", .on = {.all_test = results::UnseenComparison{}}}};
  EXPECT_EQ(unseen_csv(study),
            "split,runs,object,of,value,low,high,n\n"
            "paper,reported,all,seen,0.5,0.25,0.75,3\n"
            "paper,reported,fan,seen,,,,0\n"
            "paper,reported,all,held_out,,,,0\n"
            "paper,reported,fan,held_out,0.25,,,1\n"
            "paper,reported,all,difference,,,,0\n"
            "paper,reported,fan,difference,,,,0\n"
            "split-007,all_test,all,seen,,,,0\n"
            "split-007,all_test,all,held_out,,,,0\n"
            "split-007,all_test,all,difference,,,,0\n");
  results::Claim claim;
  claim.id = "x";
  claim.unit = "ms";
  claim.asked = results::Asked::below;
  claim.limit = 5;
  claim.kept = 4;
  claim.of = 6;
  claim.measured = {3, 2, 4, 3};
  claim.outcome = results::Outcome::holds;
  EXPECT_EQ(claims_csv({claim}),
            "id,runs,value,low,high,n,unit,asked,limit,kept,of,verdict\nx,reported,3.0,2.0,4.0,3,ms,below,5,4,6,holds\n");
}

}  // namespace
}  // namespace tactile::study
