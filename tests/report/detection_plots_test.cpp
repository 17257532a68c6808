#include "tactile/report/detection_plots.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

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
  points.reserve(41);
  for (int i = 0; i < 41; ++i) points.push_back(operating_point(-4 + 0.5 * i, 200 / (1.0 + i), 2 + i, 4 + 2 * i, 0));
  const pictures::Plot plot = operating_curve_plot("Curve", points, own);
  EXPECT_TRUE(has_row(plot, {2, 4, 5, 10}));
  const std::string svg = drawn(plot);
  EXPECT_TRUE(contains(svg, "the verdicts as they were decided"));
  EXPECT_FALSE(contains(svg, ">2.5<")) << "a few are named, not all";
  EXPECT_TRUE(contains(svg, ">1.5<"));
  EXPECT_FALSE(contains(drawn(operating_curve_plot("Without", points)), "as they were decided"));
}

SettingCurve setting(const std::string& name, bool is_stream, bool is_unseen, std::vector<results::OperatingPoint> points) {
  return {.name = name, .is_stream = is_stream, .is_unseen = is_unseen, .points = std::move(points)};
}

TEST(SettingsCurvePlot, HoldsHalfOfTheTouchesAndNineTenthsOfEachSetting) {
  const pictures::Plot plot = settings_curve_plot(
      "Settings", {setting("stream", true, false, {operating_point(0, 100, 2, 6, 0), operating_point(4, 1, 8, 300, 0.25)}),
                   setting("LeNet, t_h 40 ms", false, false, {operating_point(0, 10, 12, 40, 0)})});
  EXPECT_TRUE(has_row(plot, {2, 2, 6}));
  EXPECT_TRUE(has_row(plot, {0, 8, 100})) << "beyond 100 ms";
  EXPECT_TRUE(has_row(plot, {1, 12, 40}));
  EXPECT_EQ(plot.tables.size(), 2U) << "one of each setting";
  EXPECT_TRUE(contains(plot.script, "using 1:2") && contains(plot.script, "using 1:3"));
  const std::string svg = drawn(plot);
  for (const char* words : {">stream<", ">LeNet, t_h 40 ms<", "half of the touches", "90 % of the touches", "delay [ms]",
                            "false alarms per minute", ">none<"})
    EXPECT_TRUE(contains(svg, words)) << words;
}

TEST(SettingsCurvePlot, TellsStreamsAndUnseenObjectsApart) {
  const std::vector<results::OperatingPoint> points{operating_point(0, 10, 2, 6, 0)};
  const auto script_of = [&](bool is_stream, bool is_unseen) {
    return settings_curve_plot("Settings", {setting("one", is_stream, is_unseen, points)}).script;
  };
  EXPECT_TRUE(contains(script_of(true, false), std::string(pictures::figure_colours::slip)));
  EXPECT_FALSE(contains(script_of(true, false), std::string(pictures::figure_colours::press)));
  EXPECT_TRUE(contains(script_of(false, false), std::string(pictures::figure_colours::press)));
  EXPECT_FALSE(contains(script_of(true, false), "dt 2")) << "seen: a line";
  EXPECT_TRUE(contains(script_of(true, true), "dt 2")) << "unseen: dashes";
}

TEST(SettingsCurvePlot, BearsWhatIsMissing) {
  drawn(settings_curve_plot("No points", {setting("stream", true, false, {})}));
  const pictures::Plot plot = settings_curve_plot("Calm", {setting("stream", true, true, {operating_point(9, 0, 5, 7, 0)})});
  EXPECT_TRUE(has_row(plot, {-0.12, 5, 7})) << "left of the axis, whose decade begins at 1 a minute";
  drawn(plot);
}

}  // namespace
}  // namespace tactile::report
