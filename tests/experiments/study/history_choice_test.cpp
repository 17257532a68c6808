#include "tactile/experiments/study/history_choice.hpp"

#include <gtest/gtest.h>

#include "tactile/core/error.hpp"

namespace tactile::study {
namespace {

results::Accuracy accuracy_with(double mean, const std::map<std::string, double>& objects) {
  results::Accuracy accuracy;
  accuracy.mean.value = mean;
  for (const auto& [object, value] : objects) accuracy.objects[object].value = value;
  return accuracy;
}

TEST(ChooseHistory, TakesTheOneThatIsBestForMostObjects) {
  const results::HistoryChoice choice = choose_history({{2ms, accuracy_with(0.99, {{"a", 0.1}, {"b", 0.1}, {"c", 0.9}})},
                                                        {40ms, accuracy_with(0.5, {{"a", 0.5}, {"b", 0.5}, {"c", 0.5}})}});
  EXPECT_EQ(choice.history, 40ms) << "its mean is lower, but it is best for two of three";
  EXPECT_EQ(choice.of_objects.at("c"), 2ms);
  EXPECT_EQ(choice.counts.at(40ms), 2U);
  EXPECT_EQ(choice.counts.at(2ms), 1U);
}

TEST(ChooseHistory, OfAsManyObjectsTheHigherMeanCounts) {
  const results::HistoryChoice choice = choose_history({{2ms, accuracy_with(0.7, {{"a", 0.9}, {"b", 0.5}})},
                                                        {20ms, accuracy_with(0.1, {{"a", 0.1}, {"b", 0.1}})},
                                                        {40ms, accuracy_with(0.75, {{"a", 0.6}, {"b", 0.9}})}});
  EXPECT_EQ(choice.history, 40ms);
  EXPECT_EQ(choice.counts.at(20ms), 0U);
}

TEST(ChooseHistory, OfEqualsTheShorterCounts) {
  const results::HistoryChoice choice =
      choose_history({{20ms, accuracy_with(0.9, {{"a", 0.9}})}, {40ms, accuracy_with(0.9, {{"a", 0.9}})}});
  EXPECT_EQ(choice.history, 20ms);
  EXPECT_EQ(choice.of_objects.at("a"), 20ms);
}

TEST(ChooseHistory, NothingToChooseFromIsAnError) { EXPECT_THROW(choose_history({}), Error); }

}  // namespace
}  // namespace tactile::study
