#include "tactile/results/training_spread.hpp"

#include <gtest/gtest.h>

namespace tactile::results {
namespace {

TEST(TrainingSpread, NamesTheObjectOnWhichTrainingsAreFurthestApart) {
  const TrainingSpread spread{.history_ms = 30,
                              .mean = {0.9, 0.92, 0.91},
                              .objects = {{"fan", {0.75, 0.95, 0.9}}, {"jar", {0.9}}, {"mug", {0.96, 0.9, 0.93}}}};
  EXPECT_EQ(
      words_of(spread),
      "3 trainings with a t_h of 30 ms, each on its own reported runs: on one object their accuracies are up to 20.0 points "
      "apart (fan: 75.0 to 95.0 %), on the median object 13.0 points, in the mean over objects 2.0 points.");
  const nlohmann::json json = spread;
  EXPECT_EQ(json.at("objects").at("mug").at(1), 0.9);
  EXPECT_EQ(json.at("in_words"), words_of(spread));
}

TEST(TrainingSpread, OfOneTrainingIsNothing) {
  const TrainingSpread spread{.mean = {0.9}, .objects = {{"fan", {0.75}}}};
  EXPECT_EQ(words_of(spread), "");
  EXPECT_TRUE(nlohmann::json(spread).is_null());
}

}  // namespace
}  // namespace tactile::results
