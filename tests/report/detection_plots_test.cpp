#include "tactile/report/detection_plots.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "report/plot_rows.hpp"
#include "support/drawn_plot.hpp"
#include "tactile/pictures/plot_script.hpp"

namespace tactile::report {
namespace {

using test::contains;
using test::drawn;
using test::has_row;

results::OperatingPoint operating_point(std::optional<double> threshold, double alarms, double median_ms, double p90_ms,
                                        double missed) {
  results::OperatingPoint point{.threshold = threshold, .alarms_per_min = {.value = alarms}};
  point.median_ms.ms.value = median_ms;
  point.p90_ms.ms.value = p90_ms;
  point.missed.value = missed;
  return point;
}

TEST(OperatingCurvePlot, HoldsDelayAndMissesAgainstFalseAlarms) {
  const pictures::Plot plot =
      operating_curve_plot("Operating curve", {operating_point(0, 60, 2, 6, 0), operating_point(4, 1, 8, 300, 0.25)});
  EXPECT_TRUE(has_row(plot, {std::log10(60), 2, 6, 0}));
  EXPECT_TRUE(has_row(plot, {0, 8, 100, 25})) << "beyond 100 ms";
  const std::string svg = drawn(plot);
  for (const char* words : {">4<", ">0<", "false alarms per minute", "delay [ms]", "missed or early [%]", "half of the touches"})
    EXPECT_TRUE(contains(svg, words)) << words;
  drawn(operating_curve_plot("No alarms", {{.threshold = 0.5, .alarms_per_min = {.value = 0}}}));
  drawn(operating_curve_plot("Nothing", {}));
}

TEST(OperatingCurvePlot, MarksTheVerdictsAsDecidedAndWritesSomeThresholds) {
  const results::OperatingPoint own = operating_point({}, 100, 4, 5, 0.1);
  std::vector<results::OperatingPoint> points;
  for (int i = 0; i < 41; ++i) points.push_back(operating_point(-4 + 0.5 * i, 200 / (1.0 + i), 2 + i, 4 + 2 * i, 0));
  const pictures::Plot plot = operating_curve_plot("Curve", points, own);
  EXPECT_TRUE(has_row(plot, {2, 4, 5, 10}));
  const std::string svg = drawn(plot);
  EXPECT_TRUE(contains(svg, "the verdicts as they were decided"));
  EXPECT_FALSE(contains(svg, ">2.5<")) << "a few are named, not all";
  EXPECT_TRUE(contains(svg, ">1.5<"));
  EXPECT_FALSE(contains(drawn(operating_curve_plot("Without", points)), "as they were decided"));
}

TEST(DetectionCurvePlot, HoldsTheSharesWithTheirIntervals) {
  const std::vector<results::DetectedWithin> press{{0, {0.1, 0, 0.2, 10}}, {18, {0.9, 0.8, 0.95, 10}}};
  const std::vector<results::DetectedWithin> slip{{0, {.value = 0.25}}, {198, {.value = 0.5}}};
  const pictures::Plot plot = detection_curve_plot("Detected", press, slip);
  EXPECT_TRUE(has_row(plot, {0, 10, 0, 20}));
  EXPECT_TRUE(has_row(plot, {1, 90, 80, 95})) << "18 ms: log10(1 + 18 / 2)";
  EXPECT_TRUE(has_row(plot, {2, 50, 50, 50})) << "198 ms, without an interval";
  const std::string svg = drawn(plot);
  for (const char* words : {"time since the onset [ms]", "detected [%]", "at 0: predicted ahead of it",
                            ">95 % interval, where there is one<", ">100<"})
    EXPECT_TRUE(contains(svg, words)) << words;
  drawn(detection_curve_plot("Only press", press, {}));
  const pictures::Plot without = detection_curve_plot("No intervals", {}, slip);
  EXPECT_FALSE(contains(drawn(without), "95 %")) << "none is spoken of where there is none";
  EXPECT_FALSE(contains(without.script, "using 1:3")) << "nor drawn";
}

TEST(OverTimePlot, HoldsBothEndsOfBothClasses) {
  const results::AccuracyOverTime press{.since_onset = {{.to = 50ms, .accuracy = {0.9, 0.8, 0.95, 10}}},
                                        .before_end = {{.to = 50ms, .accuracy = {0.6, 0.5, 0.7, 10}}}};
  const pictures::Plot plot = over_time_plot("Over time", press, {});
  EXPECT_TRUE(has_row(plot, {25, 90, 80, 95}));
  EXPECT_TRUE(has_row(plot, {25, 60, 50, 70}));
  const std::string svg = drawn(plot);
  for (const char* words : {"since the onset", "before the end", ">95 % interval<"}) EXPECT_TRUE(contains(svg, words)) << words;
  const results::AccuracyOverTime of_one_run{.since_onset = {{.to = 50ms, .accuracy = {.value = 0.9}}}};
  EXPECT_TRUE(contains(drawn(over_time_plot("Of one run", press, of_one_run)), "95 % interval, where there is one"));
  EXPECT_FALSE(contains(drawn(over_time_plot("Of one run", of_one_run, {})), "95 %"));
}

TEST(OverTimePlot, LeavesOutBinsOfFewerThanThreeObjects) {
  const results::OverTimeBin many{.to = 50ms, .accuracy = {.value = 0.9, .n = 3}},
      few{.from = 50ms, .to = 100ms, .accuracy = {.value = 0.5, .n = 2}};
  const pictures::Plot plot = over_time_plot("Over time", {.since_onset = {many, few}}, {.before_end = {few}});
  EXPECT_TRUE(has_row(plot, {25, 90, 90, 90}));
  const auto& tables = plot.tables;
  const auto has_few = std::count_if(tables.begin(), tables.end(), [](const pictures::PlotTable& table) {
    return std::find(table.values.begin(), table.values.end(), 75.0) != table.values.end();
  });
  EXPECT_EQ(has_few, 1) << "drawn only where no bin of the class has more";
}

}  // namespace
}  // namespace tactile::report
