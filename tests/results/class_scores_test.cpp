#include "tactile/results/class_scores.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace tactile::results {
namespace {

TEST(ClassScores, AreReadBackAsTheyAreWritten) {
  ClassScores scores;
  for (const Touch touch : all_touches) {
    const auto i = static_cast<std::size_t>(touch);
    scores.all[i] = {.precision = {.value = 0.1 + 0.1 * static_cast<double>(i)}, .recall = {0.9, 0.8, 0.95, 4}, .f1 = {}};
    scores.objects["fan"][i].f1 = {.value = 0.5};
  }
  const nlohmann::json json = scores;
  EXPECT_EQ(json.at("press").at("precision").at("value"), 0.2);
  EXPECT_EQ(json.at("none").at("objects").at("fan").at("f1").at("value"), 0.5);
  EXPECT_EQ(nlohmann::json(JsonView(json, "eval.json").get<ClassScores>()), json);
}

}  // namespace
}  // namespace tactile::results
