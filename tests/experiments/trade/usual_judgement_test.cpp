#include "tactile/experiments/trade/usual_judgement.hpp"

#include <gtest/gtest.h>

namespace tactile::trade {
namespace {

results::Figure about(double value, std::size_t trainings) {
  return {.value = value, .low = value - 0.001, .high = value + 0.001, .n = 10, .trainings = trainings};
}

/// The usual setting, and one with int8 that is faster by 20 us and equal in all else.
std::vector<TradePoint> usual_and_faster(std::size_t trainings) {
  std::vector<TradePoint> points(2);
  points[0].design = "usual";
  points[0].networks.resize(trainings);
  points[1].setting.precision = model::Precision::int8;
  points[1].difference = results::TradeDifference{.accuracy = about(0, trainings),
                                                  .delay_us = about(0, trainings),
                                                  .missed = about(0, trainings),
                                                  .episodes_per_min = about(0, trainings),
                                                  .us_p50 = about(-20, 1),
                                                  .us_p99 = about(-20, 1)};
  return points;
}

TEST(JudgementOfUsual, NamesABetterSetting) {
  const std::string text = judgement_of_usual(usual_and_faster(5), {});
  EXPECT_NE(text.find("Better than it by the whole 95 % intervals of their differences: int8 ("), std::string::npos) << text;
  EXPECT_EQ(text.find("could not be tested"), std::string::npos) << text;
}

TEST(JudgementOfUsual, IsNoEvidenceWhereTheRuleWasApplied) {
  std::vector<TradePoint> points = usual_and_faster(5);
  points[1].difference->accuracy = {.value = -0.02, .low = -0.03, .high = -0.01, .n = 10, .trainings = 5};
  const std::string text = judgement_of_usual(points, {});
  EXPECT_NE(text.find("None of the tested settings (1) is better"), std::string::npos) << text;
  EXPECT_NE(text.find("This is no evidence for another default."), std::string::npos) << text;
  EXPECT_NE(text.find("The most accurate of those that are faster by the whole intervals: int8 ("), std::string::npos) << text;
}

TEST(JudgementOfUsual, SaysThatTheRuleCouldNotBeApplied) {
  // With four trainings: better by its whole intervals, but the rule needs five.
  const std::string text = judgement_of_usual(usual_and_faster(4), {});
  EXPECT_NE(
      text.find("Whether another setting is better could not be tested: that needs 5 trainings of both settings, and a 95 % "
                "interval of each difference. The usual setting has 4 trainings."),
      std::string::npos)
      << text;
  EXPECT_EQ(text.find("no evidence"), std::string::npos) << text;
  EXPECT_EQ(text.find("is better by"), std::string::npos) << text;
  // Without an interval neither.
  std::vector<TradePoint> points = usual_and_faster(5);
  points[1].difference->missed.low.reset();
  EXPECT_NE(judgement_of_usual(points, {}).find("could not be tested"), std::string::npos);
}

TEST(JudgementOfUsual, CountsTheSettingsThatCouldNotBeTested) {
  std::vector<TradePoint> points = usual_and_faster(5);
  points[1].difference->us_p50 = about(20, 1);
  points.push_back(usual_and_faster(2)[1]);
  points.push_back(points.back());
  const std::string text = judgement_of_usual(points, {});
  EXPECT_NE(text.find("None of the tested settings (1) is better"), std::string::npos) << text;
  EXPECT_NE(text.find("2 other settings could not be tested: that needs 5 trainings"), std::string::npos) << text;
}

TEST(JudgementOfUsual, SaysThatTheProbabilityOfTheFrontsIsUnknown) {
  std::vector<TradePoint> points = usual_and_faster(5);
  EXPECT_TRUE(judgement_of_usual(points, {})
                  .starts_with("How probable it is that the usual setting is on a front is unknown: that needs 3 objects. "));
  points[0].front_probability = {0.25, 0.5};
  EXPECT_TRUE(judgement_of_usual(points, {}).starts_with("The usual setting is on the front of accuracy and time in 25 % "));
  EXPECT_EQ(judgement_of_usual({points.data(), 1}, {}), "") << "there is no other setting";
}

}  // namespace
}  // namespace tactile::trade
