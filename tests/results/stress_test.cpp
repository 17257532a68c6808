#include "tactile/results/stress.hpp"

#include <gtest/gtest.h>

#include "tactile/core/error.hpp"
#include "tactile/results/experiment_file.hpp"

namespace tactile::results {
namespace {

Stress a_stress() {
  StressPoint clean{.severity = 0, .accuracy = {.value = 0.9, .low = 0.8, .high = 0.95, .n = 3}};
  clean.whole.within_50_ms.value = 0.75;
  clean.whole.alarms_per_min.value = 4;
  StressPoint worse = clean;
  worse.severity = 100;
  worse.accuracy.value = 0.7;
  worse.accuracy_change.value = -0.2;
  StressCurve curve{.name = "noise", .unit = "kev/s", .meaning = "Noise.", .points = {clean, worse}};
  curve.holds = HoldsUpTo{.severity = {.value = 25, .low = 10, .high = 40, .n = 3}};
  StressedModel model{.name = "a", .trainings = {"a", "b"}, .runs = {"fan/02"}, .curves = {curve}};
  return {.title = "Simulated runs", .simulated = true, .seed = 5, .models = {model}};
}

TEST(Stress, IsReadAsWritten) {
  const nlohmann::json json = a_stress();
  const Stress read = JsonView(json, "stress.json").get<Stress>();
  EXPECT_EQ(nlohmann::json(read), json);
  EXPECT_EQ(read.models.at(0).curves.at(0).points.at(1).accuracy_change.value, -0.2);
  EXPECT_EQ(read.models.at(0).trainings, (std::vector<std::string>{"a", "b"}));
}

TEST(Stress, OfAnotherFormatIsRefused) {
  const nlohmann::json json{{"format", "tactile-trade-1"}};
  EXPECT_THROW(experiment_in<Stress>(JsonView(json, "stress.json")), Error);
}

TEST(Stress, SaysInWordsHowFarItHolds) {
  StressCurve curve = a_stress().models.at(0).curves.at(0);
  EXPECT_EQ(words_of(curve), "up to 25 kev/s [10, 40]");
  curve.holds->is_beyond = true;
  EXPECT_EQ(words_of(curve), "beyond 100 kev/s");
  curve.unit.clear();
  EXPECT_EQ(words_of(curve), "holds");
  curve.holds->is_beyond = false;
  EXPECT_EQ(words_of(curve), "does not hold") << "a mirror is on or off";
  curve.holds.reset();
  EXPECT_EQ(words_of(curve), "unknown");
}

}  // namespace
}  // namespace tactile::results
