#include "tactile/evaluation/class_scores.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tactile::evaluation {
namespace {

results::RunConfusion run_with(std::string object, std::array<std::array<std::uint64_t, 3>, 3> counts) {
  return {{std::move(object)}, {counts}};
}

TEST(ClassScores, AreThoseOfTheCountsOfAllRunsTogether) {
  const std::vector<results::RunConfusion> runs{run_with("fan", {{{8, 1, 1}, {2, 7, 1}, {0, 0, 10}}}),
                                                run_with("box", {{{9, 0, 1}, {0, 10, 0}, {3, 3, 4}}})};
  const results::ClassScores scores = class_scores_of(runs);
  const results::ClassScore& press = scores.all[static_cast<std::size_t>(Touch::press)];
  EXPECT_DOUBLE_EQ(press.precision.value, 17.0 / 21);  // predicted press: 1 + 7 + 10 + 3
  EXPECT_DOUBLE_EQ(press.recall.value, 17.0 / 20);
  EXPECT_DOUBLE_EQ(press.f1.value, 34.0 / 41);
  EXPECT_EQ(press.f1.n, 2U);
  EXPECT_FALSE(press.f1.low.has_value());
  EXPECT_DOUBLE_EQ(scores.objects.at("fan")[2].precision.value, 10.0 / 12);
  EXPECT_DOUBLE_EQ(scores.objects.at("box")[2].recall.value, 0.4);
}

TEST(ClassScores, AreUnknownWhereNothingIsPredictedOrTrue) {
  const std::vector<results::RunConfusion> runs{run_with("fan", {{{5, 0, 0}, {5, 0, 0}, {0, 0, 0}}}), run_with("empty", {})};
  const results::ClassScores scores = class_scores_of(runs);
  EXPECT_TRUE(std::isnan(scores.all[1].precision.value));
  EXPECT_DOUBLE_EQ(scores.all[1].recall.value, 0.0);
  EXPECT_DOUBLE_EQ(scores.all[1].f1.value, 0.0);
  EXPECT_TRUE(std::isnan(scores.all[2].f1.value));
  EXPECT_EQ(scores.objects.count("empty"), 0U);
  const nlohmann::json json = scores;
  EXPECT_TRUE(json.at("press").at("precision").at("value").is_null());
  EXPECT_EQ(json.at("none").at("objects").at("fan").at("recall").at("value"), 1.0);
}

TEST(ClassScores, OfAClassOfOneSampleAreAllOrNothing) {
  for (const bool right : {true, false}) {
    const std::vector<results::RunConfusion> runs{
        run_with("fan", {{{5, 1, 0}, {0, 6, 0}, {right ? 0U : 1U, 0, right ? 1U : 0U}}}),
        run_with("box", {{{6, 0, 0}, {1, 5, 0}, {0, 0, 0}}}), run_with("cup", {{{6, 0, 0}, {0, 6, 0}, {0, 0, 0}}})};
    const results::ClassScores scores = class_scores_of(runs);
    const results::ClassScore& slip = scores.all[static_cast<std::size_t>(Touch::slip)];
    EXPECT_EQ(slip.recall.value, right ? 1.0 : 0.0);
    EXPECT_EQ(std::isnan(slip.precision.value), !right) << "a class that is never predicted has no precision";
    EXPECT_EQ(slip.f1.value, right ? 1.0 : 0.0);
    if (slip.recall.low) {
      EXPECT_LE(*slip.recall.low, slip.recall.value);
      EXPECT_GE(*slip.recall.high, slip.recall.value);
    }
    EXPECT_TRUE(std::isnan(scores.objects.at("box")[2].recall.value));
    EXPECT_FALSE(scores.objects.at("fan")[2].recall.low.has_value()) << "one run cannot be drawn from";
  }
}

}  // namespace
}  // namespace tactile::evaluation
