#include "tactile/report/stress_plots.hpp"

#include <gtest/gtest.h>

#include "report/plot_rows.hpp"
#include "support/drawn_plot.hpp"

namespace tactile::report {
namespace {

results::StressPoint point(double severity, double accuracy, double alarms) {
  results::StressPoint point{.severity = severity,
                             .accuracy = {.value = accuracy, .low = accuracy - 0.1, .high = accuracy + 0.05}};
  point.whole.within_50_ms.value = accuracy;
  point.whole.alarms_per_min.value = alarms;
  return point;
}

results::Stress a_stress() {
  const results::StressCurve noise{
      .name = "noise", .unit = "kev/s", .points = {point(0, 0.9, 0), point(50, 0.8, 9), point(1000, 0.5, 99)}};
  return {.title = "Stress", .simulated = true, .models = {{.name = "lenet", .trainings = {"lenet"}, .curves = {noise}}}};
}

TEST(StressPlot, HasEachSeverityAtAnEqualDistanceWithItsInterval) {
  const pictures::Plot plot = stress_plot(a_stress(), StressMeasure::accuracy);
  EXPECT_TRUE(test::has_row(plot, {0, 90, 80, 95}));
  EXPECT_TRUE(test::has_row(plot, {2, 50, 40, 55}));
  EXPECT_TRUE(test::contains(plot.script, "'1k' 2"));
  EXPECT_TRUE(test::contains(plot.script, "(simulated runs)"));
  EXPECT_TRUE(test::contains(plot.script, "lenet"));
}

TEST(StressPlot, HasFalseAlarmsOnALogarithmicAxisFromZero) {
  const pictures::Plot plot = stress_plot(a_stress(), StressMeasure::false_alarms);
  EXPECT_TRUE(test::has_row(plot, {0, 0, 0, 0}));
  EXPECT_TRUE(test::has_row(plot, {1, 1, 1, 1})) << "log10(9 + 1)";
}

TEST(StressPlot, MarksAnIntervalThatLeavesThePanel) {
  results::Stress stress = a_stress();
  const auto has_mark = [&] { return test::contains(stress_plot(stress, StressMeasure::false_alarms).script, "with points"); };
  EXPECT_FALSE(has_mark());
  // The axis ends at 1.5 times the largest value, 99.
  results::Figure& alarms = stress.models[0].curves[0].points[2].whole.alarms_per_min;
  alarms.low = 80;
  alarms.high = 148;
  EXPECT_FALSE(has_mark());
  alarms.high = 150;
  EXPECT_TRUE(has_mark());
  EXPECT_TRUE(test::contains(stress_plot(stress, StressMeasure::false_alarms).script, " pt 9 ")) << "upwards";
}

TEST(StressPlot, DrawsModelsAsideOfEachOtherAlsoWithoutCurves) {
  results::Stress stress = a_stress();
  stress.models.push_back(stress.models[0]);
  const pictures::Plot plot = stress_plot(stress, StressMeasure::within_50_ms);
  EXPECT_TRUE(test::has_row(plot, {-0.025, 90, 90, 90})) << "half of 0.025 of the axis, which is 2 long";
  EXPECT_FALSE(test::drawn(plot).empty());
  EXPECT_FALSE(test::drawn(stress_plot(a_stress(), StressMeasure::false_alarms, true)).empty());
}

}  // namespace
}  // namespace tactile::report
