#include "tactile/evaluation/delay_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tactile::evaluation {
namespace {

using results::DetectionOutcome;

results::TouchOutcome detected(Touch touch, double ms) { return {touch, DetectionOutcome::detected, ms}; }
results::TouchOutcome not_detected(Touch touch, DetectionOutcome outcome, double limit_ms = 500) {
  return {touch, outcome, limit_ms};
}

results::Cell cell_of(const std::string& object, std::vector<results::TouchOutcome> touches) {
  results::Cell cell{{object}};
  cell.touches = std::move(touches);
  return cell;
}

TEST(DelayTable, AveragesDetectedTouchesAndCountsTheOthers) {
  const std::vector<results::Cell> cells{
      cell_of("fan", {detected(Touch::press, 2), detected(Touch::slip, 4)}),
      cell_of("fan", {detected(Touch::press, 4), not_detected(Touch::slip, DetectionOutcome::missed)}),
      cell_of("box", {detected(Touch::press, 12), not_detected(Touch::press, DetectionOutcome::early)}),
  };
  const results::DelayTable press = delay_table(cells, Touch::press);
  EXPECT_DOUBLE_EQ(press.all.mean_ms.value, 6.0);
  EXPECT_DOUBLE_EQ(press.all.median_ms.value, 4.0);
  EXPECT_NEAR(press.all.sem_ms, std::sqrt(28.0 / 3), 1e-12);  // deviations -4, -2, 6: variance 56/2, over 3 values
  EXPECT_EQ(press.all.intervals, 4U);
  EXPECT_EQ(press.all.misses, 0U);
  EXPECT_EQ(press.all.early, 1U);
  EXPECT_EQ(press.all.mean_ms.n, 3U) << "runs of these two objects";
  EXPECT_DOUBLE_EQ(press.objects.at("fan").mean_ms.value, 3.0);
  EXPECT_EQ(press.objects.at("fan").mean_ms.n, 2U);
  EXPECT_DOUBLE_EQ(press.objects.at("box").median_ms.value, 12.0);
  EXPECT_TRUE(std::isnan(press.objects.at("box").sem_ms));

  const results::DelayTable slip = delay_table(cells, Touch::slip);
  EXPECT_DOUBLE_EQ(slip.all.mean_ms.value, 4.0);
  EXPECT_EQ(slip.all.intervals, 2U);
  EXPECT_EQ(slip.all.misses, 1U);
  EXPECT_EQ(slip.objects.count("box"), 0U);
}

TEST(DelayTable, HasNoIntervalBeyondTheLimit) {
  // One of ten presses of an object is late in one object, and six are missed in two others.
  std::vector<results::Cell> cells;
  for (const auto& [object, late, misses] :
       {std::tuple("fan", 1, 0), std::tuple("box", 0, 6), std::tuple("hub", 0, 6), std::tuple("jar", 0, 0)}) {
    cells.push_back(cell_of(object, {}));
    for (int i = 0; i < 10; ++i) {
      cells.back().touches.push_back(i < misses ? not_detected(Touch::press, DetectionOutcome::missed)
                                                : detected(Touch::press, i < misses + late ? 480 : 4));
    }
  }
  const results::DelaySummary all = delay_table(cells, Touch::press).all;
  EXPECT_DOUBLE_EQ(all.quantile_of_all_ms.ms.value, 500);
  EXPECT_TRUE(all.quantile_of_all_ms.is_lower_bound);
  EXPECT_FALSE(all.quantile_of_all_ms.ms.has_interval()) << "that of a limit says nothing of the delay";
  for (const results::Figure* figure : {&all.mean_ms, &all.median_ms, &all.median_of_all_ms.ms, &all.missed}) {
    ASSERT_TRUE(figure->has_interval());
    EXPECT_GE(*figure->low, 0);
    EXPECT_LE(*figure->high, figure == &all.missed ? 1 : 500);
  }
}

TEST(DelayTable, WithoutADetectionHasNoMeanInJson) {
  const std::vector<results::Cell> cells{cell_of("fan", {not_detected(Touch::slip, DetectionOutcome::missed)})};
  const nlohmann::json json = delay_table(cells, Touch::slip);
  EXPECT_TRUE(json.at("mean").at("value").is_null());
  EXPECT_TRUE(json.at("sem").is_null());
  EXPECT_EQ(json.at("misses"), 1);
  EXPECT_EQ(json.at("objects").at("fan").at("intervals"), 1);
}

TEST(DelayQuantile, OfAClassIsBoundedByTheLimitsOfThatClass) {
  const std::vector<results::Cell> cells{cell_of("fan", {not_detected(Touch::press, DetectionOutcome::missed, 80),
                                                         not_detected(Touch::slip, DetectionOutcome::missed, 500)})};
  const RunFigures figures(std::span<const results::Cell>(cells), nullptr, [](const results::Cell&) { return true; });
  const results::CensoredQuantile press = delay_quantile(cells, figures, 0.5, Delay::press);
  EXPECT_DOUBLE_EQ(press.ms.value, 80);
  EXPECT_TRUE(press.is_lower_bound);
}

TEST(DelayQuantile, FromGrossSlipIsBoundedFromThere) {
  results::TouchOutcome slip = not_detected(Touch::slip, DetectionOutcome::missed, 500);
  slip.gross_ms = 480;
  const std::vector<results::Cell> cells{cell_of("fan", {slip})};
  const RunFigures figures(std::span<const results::Cell>(cells), nullptr, [](const results::Cell&) { return true; });
  EXPECT_DOUBLE_EQ(delay_quantile(cells, figures, 0.5, Delay::from_gross).ms.value, 480);
}

}  // namespace
}  // namespace tactile::evaluation
