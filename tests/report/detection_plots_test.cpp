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

/// Of ten intervals so many are missed.
results::OperatingPoint operating_point(double threshold, double alarms, double press_ms, std::uint64_t press_misses,
                                        double slip_ms, std::uint64_t slip_misses) {
  return {.threshold = threshold,
          .press = {.mean_ms = {.value = press_ms}, .intervals = 10, .misses = press_misses},
          .slip = {.mean_ms = {.value = slip_ms}, .intervals = 10, .misses = slip_misses},
          .false_alarms_per_min = {.value = alarms}};
}

TEST(OperatingCurvePlot, HoldsDelayAndMissesAgainstFalseAlarms) {
  const pictures::Plot plot =
      operating_curve_plot("Operating curve", {operating_point(0.5, 6, 2, 0, 3, 1), operating_point(0.9, 1, 8, 2, 12, 4)});
  EXPECT_TRUE(has_row(plot, {std::log10(6), 2, 3}));
  EXPECT_TRUE(has_row(plot, {0, 20, 40}));
  const std::string svg = drawn(plot);
  for (const char* words : {"0.5", "0.9", "false alarms per minute", "mean delay [ms]", "missed or early [%]"})
    EXPECT_TRUE(contains(svg, words)) << words;
  drawn(operating_curve_plot("No alarms", {{.threshold = 0.5, .false_alarms_per_min = {.value = 0}}}));
  drawn(operating_curve_plot("Nothing", {}));
}

TEST(OperatingCurvePlot, MarksTheNetworksOwnPointAndWritesThresholdsNextToThePoints) {
  const results::OperatingPoint own = operating_point(NAN, 100, 4, 1, 5, 2);
  std::vector<results::OperatingPoint> points;
  for (const double threshold : {0.1, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.999})
    points.push_back(operating_point(threshold, 10, 2 + threshold, 0, 3 + threshold, 0));
  const pictures::Plot plot = operating_curve_plot("Crowded", points, own);
  EXPECT_TRUE(has_row(plot, {2, 4, 5}));
  EXPECT_TRUE(has_row(plot, {2, 10, 20}));
  const std::string svg = drawn(plot);
  EXPECT_TRUE(contains(svg, "the most probable class, without a threshold"));
  EXPECT_FALSE(contains(svg, ">0.995<")) << "a few are named, not all";
  EXPECT_TRUE(contains(svg, ">0.5<"));
  // A label is near its point, in the colour of its curve.
  EXPECT_NE(plot.script.find("front textcolor rgb '" + std::string(pictures::figure_colours::slip) + "'"), std::string::npos);
  EXPECT_FALSE(contains(drawn(operating_curve_plot("Without", points)), "without a threshold"));
}

TEST(OperatingCurvePlot, TakesFalseAlarmsOutsideLabelsWhereTheyAreKnown) {
  results::OperatingPoint point = operating_point(0.5, 6, 2, 0, 3, 1);
  point.outside_labels_per_min = {.value = 100};
  EXPECT_TRUE(has_row(operating_curve_plot("Operating curve", {point}), {2, 2, 3}));
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
