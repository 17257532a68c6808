#include "tactile/report/result_plots.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/drawn_plot.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/report/frames_picture.hpp"
#include "tactile/report/plot_script.hpp"

namespace tactile {
namespace {

using test::drawn;
using test::TemporaryFolder;

bool has_row(const Plot& plot, const std::vector<double>& row) {
  return std::any_of(plot.tables.begin(), plot.tables.end(), [&](const PlotTable& table) {
    if (table.columns != row.size()) return false;
    for (std::size_t begin = 0; begin < table.values.size(); begin += table.columns) {
      bool same = true;
      for (std::size_t i = 0; i < row.size(); ++i) same = same && std::abs(table.values[begin + i] - row[i]) < 1e-9;
      if (same) return true;
    }
    return false;
  });
}

bool tells(const std::string& svg, const std::string& words) { return svg.find(words) != std::string::npos; }

HistoryCurve curve(const std::string& name, const std::vector<std::pair<double, double>>& points) {
  HistoryCurve curve{.name = name, .points = {}};
  for (const auto& [history, accuracy] : points)
    curve.points.push_back(
        {.history_ms = history, .accuracy = {.value = accuracy, .low = accuracy - 0.01, .high = accuracy + 0.01, .n = 9}});
  return curve;
}

TEST(BestHistory, IsTheFirstGreatestOfThoseMeasured) {
  EXPECT_EQ(best_of(curve("a", {{2, 0.8}, {20, 0.9}, {40, 0.9}}))->history_ms, 20);
  const HistoryCurve unmeasured = curve("a", {{2, NAN}});
  EXPECT_EQ(best_of(unmeasured), unmeasured.points.end());
  const HistoryCurve empty;
  EXPECT_EQ(best_of(empty), empty.points.end());
}

TEST(AccuracyByHistoryPlot, HoldsEachObjectInPercentWithItsIntervalAndItsBest) {
  const Plot plot =
      accuracy_by_history_plot("By history", {curve("fan", {{2, 0.8}, {40, 0.96}}), curve("usb-hub", {{2, 0.85}, {40, 0.84}})});
  EXPECT_TRUE(has_row(plot, {2, 80, 79, 81}));
  EXPECT_TRUE(has_row(plot, {40, 84, 83, 85}));
  EXPECT_TRUE(has_row(plot, {40, 96}));  // the best of the fan, marked
  EXPECT_TRUE(has_row(plot, {2, 85}));   // that of the hub
  const std::string svg = drawn(plot);
  for (const char* words : {"By history", "fan", "usb-hub", "accuracy [%]", "history t_h [ms]"})
    EXPECT_TRUE(tells(svg, words)) << words;
}

TEST(AccuracyByHistoryPlot, BearsWhatIsMissingManyObjectsAndLongNames) {
  drawn(accuracy_by_history_plot("Nothing", {}));
  drawn(accuracy_by_history_plot("Unmeasured", {curve("fan", {{2, NAN}, {40, NAN}})}));
  std::vector<HistoryCurve> many(100, curve(std::string(300, 'm'), {{2, 0.5}, {40, 0.9}}));
  const std::string svg = drawn(accuracy_by_history_plot("Many", many));
  EXPECT_TRUE(tells(svg, "The first 60 of 100 are shown."));
  EXPECT_FALSE(tells(svg, std::string(30, 'm')));
}

TEST(DelayPlot, HoldsBarsWhiskersAndWhatWasMissed) {
  const Plot plot = delay_plot(
      "Delays", {"fan", "usb-hub"}, {{"fan", {.mean_ms = {.value = 4}, .sem_ms = 0.5, .intervals = 9, .misses = 1, .early = 2}}},
      {{"fan", {.mean_ms = {.value = 2}, .sem_ms = 0, .intervals = 9}}, {"usb-hub", {.intervals = 3, .misses = 3}}});
  EXPECT_TRUE(has_row(plot, {2, 1, 0, 4, 0.68, 1.32}));  // the fan, on top: its bar from 0 to 4
  EXPECT_TRUE(has_row(plot, {4, 1, 3.5, 4.5}));
  EXPECT_TRUE(has_row(plot, {2, 1, 2, 2}));
  const std::string svg = drawn(plot);
  for (const char* words : {"press", "slip", "fan", "usb-hub", "4.0, 1 missed, 2 early", "none, 3 missed", "no interval", "5 ms"})
    EXPECT_TRUE(tells(svg, words)) << words;
  drawn(delay_plot("Nothing", {}, {}, {}));
}

TEST(UnseenPlot, HoldsBothAccuraciesOfEachObject) {
  const Plot plot = unseen_plot("Unseen", {{"fan", {{0.97, 0.96, 0.98, 9}, {0.90, 0.85, 0.94, 9}, {}}},
                                           {"sprayer", {{.value = 0.99}, {.value = 0.5}, {}}}});
  EXPECT_TRUE(has_row(plot, {97, 1.14, 96, 98}));
  EXPECT_TRUE(has_row(plot, {90, 0.86, 85, 94}));
  EXPECT_TRUE(has_row(plot, {99, 0.14, 99, 99}));  // without an interval: a point
  const std::string svg = drawn(plot);
  EXPECT_TRUE(tells(svg, "sprayer"));
  EXPECT_TRUE(tells(svg, "Whiskers: 95 % intervals where three could be drawn."));
  const Figure bounded{0.97, 0.96, 0.98, 9}, single{.value = 0.5};
  EXPECT_TRUE(tells(drawn(unseen_plot("All", {{"fan", {bounded, bounded, {}}}})), "Whiskers: 95 % intervals."));
  const std::string without = drawn(unseen_plot("None", {{"fan", {single, single, {}}}}));
  EXPECT_TRUE(tells(without, "No interval for want of three"));
  EXPECT_FALSE(tells(without, "95 %"));
  drawn(unseen_plot("Nothing", {}));
}

TEST(ConfusionPlot, TellsCountsAndSharesOfTheRow) {
  const std::string svg = drawn(confusion_plot("Confusion", {.counts = {{{90, 10, 0}, {1, 3, 0}, {0, 0, 0}}}}));
  for (const char* words : {"90.0 %", "10.0 %", "75.0 %", "25.0 %", "no sample", "said", "true", ">90<", ">3<"})
    EXPECT_TRUE(tells(svg, words)) << words;
}

/// Of ten intervals so many are missed.
OperatingPoint operating_point(double threshold, double alarms, double press_ms, std::uint64_t press_misses, double slip_ms,
                               std::uint64_t slip_misses) {
  return {.threshold = threshold,
          .press = {.mean_ms = {.value = press_ms}, .intervals = 10, .misses = press_misses},
          .slip = {.mean_ms = {.value = slip_ms}, .intervals = 10, .misses = slip_misses},
          .false_alarms_per_min = {.value = alarms}};
}

TEST(OperatingCurvePlot, HoldsDelayAndMissesAgainstFalseAlarms) {
  const Plot plot =
      operating_curve_plot("Operating curve", {operating_point(0.5, 6, 2, 0, 3, 1), operating_point(0.9, 1, 8, 2, 12, 4)});
  EXPECT_TRUE(has_row(plot, {std::log10(6), 2, 3}));
  EXPECT_TRUE(has_row(plot, {0, 20, 40}));
  const std::string svg = drawn(plot);
  for (const char* words : {"0.5", "0.9", "false alarms per minute", "mean delay [ms]", "missed or early [%]"})
    EXPECT_TRUE(tells(svg, words)) << words;
  drawn(operating_curve_plot("No alarms", {{.threshold = 0.5, .false_alarms_per_min = {.value = 0}}}));
  drawn(operating_curve_plot("Nothing", {}));
}

TEST(OperatingCurvePlot, MarksTheNetworksOwnPointAndTellsThresholdsBesideThePoints) {
  const OperatingPoint own = operating_point(NAN, 100, 4, 1, 5, 2);
  std::vector<OperatingPoint> points;
  for (const double threshold : {0.1, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.999})
    points.push_back(operating_point(threshold, 10, 2 + threshold, 0, 3 + threshold, 0));
  const Plot plot = operating_curve_plot("Crowded", points, own);
  EXPECT_TRUE(has_row(plot, {2, 4, 5}));
  EXPECT_TRUE(has_row(plot, {2, 10, 20}));
  const std::string svg = drawn(plot);
  EXPECT_TRUE(tells(svg, "diamonds: no threshold"));
  EXPECT_FALSE(tells(svg, ">0.995<")) << "a few are told, not all";
  EXPECT_TRUE(tells(svg, ">0.5<"));
  // A label stands beside its point, in the colour of its curve.
  EXPECT_NE(plot.script.find("textcolor rgb '" + std::string(figure_colours::slip) + "' front"), std::string::npos);
  EXPECT_FALSE(tells(drawn(operating_curve_plot("Without", points)), "no threshold"));
}

TEST(ReliabilityPlot, HoldsAccuracyByCertaintyAndLeavesEmptyBinsOut) {
  const Plot plot = reliability_plot(
      "Reliability", {{.from = 0.4, .to = 0.5, .samples = 0, .confidence = NAN, .accuracy = {}},
                      {.from = 0.9, .to = 1, .samples = 500, .confidence = 0.97, .accuracy = {0.95, 0.93, 0.97, 10}}});
  EXPECT_TRUE(has_row(plot, {97, 95, 93, 97}));
  EXPECT_TRUE(has_row(plot, {95, 500, 90, 100, 0.8, 500}));
  EXPECT_TRUE(tells(drawn(plot), "largest probability [%]"));
  drawn(reliability_plot("Nothing", {}));
}

TEST(ReliabilityPlot, DrawsWhatStandsOnFewSamplesHollow) {
  const Plot plot = reliability_plot(
      "Reliability", {{.from = 0.4, .to = 0.5, .samples = few_samples - 1, .confidence = 0.45, .accuracy = {.value = 1}},
                      {.from = 0.9, .to = 1, .samples = few_samples, .confidence = 0.97, .accuracy = {0.95, 0.93, 0.97, 10}}});
  ASSERT_GE(plot.tables.size(), 2U);
  EXPECT_EQ(plot.tables[0].values, (std::vector<double>{97, 95, 93, 97}));
  EXPECT_EQ(plot.tables[1].values, (std::vector<double>{45, 100, 100, 100}));
  EXPECT_TRUE(tells(drawn(plot), "Hollow: fewer than 20 samples"));
}

TEST(Captions, SpeakOfIntervalsAndWhiskersOnlyWhereThereAreSome) {
  const HistoryCurve bare{.name = "fan", .points = {{.history_ms = 2, .accuracy = {.value = 0.9, .n = 1}}}};
  const std::string without = drawn(accuracy_by_history_plot("By history", {bare}));
  EXPECT_FALSE(tells(without, "with its 95 % interval"));
  EXPECT_TRUE(tells(without, "no interval for want of three runs"));
  EXPECT_TRUE(
      tells(drawn(accuracy_by_history_plot("By history", {bare, curve("hub", {{2, 0.8}})})), "where three could be drawn"));
  EXPECT_FALSE(tells(drawn(delay_plot("Delays", {"fan"}, {{"fan", {.mean_ms = {.value = 4}, .intervals = 1}}}, {})), "whiskers"));
  EXPECT_TRUE(tells(drawn(delay_plot("Delays", {"fan"}, {{"fan", {.mean_ms = {.value = 4}, .sem_ms = 1, .intervals = 2}}}, {})),
                    "whiskers"));
}

TEST(TrainingPlot, HasMoreThanOneTicOnTheAxisOfLosses) {
  const std::string svg = drawn(training_plot(
      "Training",
      {{.name = "a", .epochs = {{.epoch = 1, .loss = 0.5, .accuracy = 0.8}, {.epoch = 2, .loss = 0.03, .accuracy = 0.9}}}}));
  for (const char* tic : {">0.05<", ">0.1<", ">0.2<", ">0.5<"}) EXPECT_TRUE(tells(svg, tic)) << tic << svg;
}

TEST(TrainingPlot, NamesEightTrainingsAndCountsTheRest) {
  std::vector<TrainingCurve> curves;
  for (int i = 0; i < 11; ++i) {
    curves.push_back({.name = fmt::format("model-{}", i),
                      .epochs = {{.epoch = 1, .loss = 0.5, .accuracy = 0.8, .later_accuracy = NAN},
                                 {.epoch = 2, .loss = 0.1, .accuracy = 0.97, .later_accuracy = 0.9}}});
  }
  const Plot plot = training_plot("Training", curves);
  EXPECT_TRUE(has_row(plot, {2, 0.1, 97, 90}));
  const std::string svg = drawn(plot);
  EXPECT_TRUE(tells(svg, "model-7"));
  EXPECT_FALSE(tells(svg, "model-8"));
  EXPECT_TRUE(tells(svg, "grey: 3 more"));
  EXPECT_TRUE(tells(svg, "validation"));
  drawn(training_plot("Nothing", {}));
  drawn(training_plot("No epoch", {{.name = "a", .epochs = {}}}));
}

TEST(OverTimePlot, HoldsBothEndsOfBothClasses) {
  const AccuracyOverTime press{.since_onset = {{.to = 50ms, .accuracy = {0.9, 0.8, 0.95, 10}}},
                               .before_end = {{.to = 50ms, .accuracy = {0.6, 0.5, 0.7, 10}}}};
  const Plot plot = over_time_plot("Over time", press, {});
  EXPECT_TRUE(has_row(plot, {25, 90, 80, 95}));
  EXPECT_TRUE(has_row(plot, {25, 60, 50, 70}));
  const std::string svg = drawn(plot);
  for (const char* words : {"since the onset", "before the end", "Whiskers: 95 % intervals."})
    EXPECT_TRUE(tells(svg, words)) << words;
  const AccuracyOverTime of_one_run{.since_onset = {{.to = 50ms, .accuracy = {.value = 0.9}}}};
  EXPECT_TRUE(
      tells(drawn(over_time_plot("Of one run", press, of_one_run)), "Whiskers: 95 % intervals where three could be drawn."));
  EXPECT_FALSE(tells(drawn(over_time_plot("Of one run", of_one_run, {})), "95 %"));
}

TEST(FramesPlot, ShowsCountsRightWayUpAndRefusesWhatIsNoFrame) {
  TouchFrame frame{.caption = "30 ms into press",
                   .touch = Touch::press,
                   .events = 42,
                   .raw = cv::Mat::zeros(3, 4, CV_32F),
                   .heatmap = cv::Mat::zeros(6, 8, CV_8U)};
  frame.raw.at<float>(0, 1) = 7;  // in the top row, which gnuplot takes last
  const Plot plot = frames_plot("Frames", {frame});
  ASSERT_EQ(plot.tables.size(), 2U);
  EXPECT_EQ(plot.tables[0].columns, 4U);
  EXPECT_EQ(plot.tables[0].values[9], 7);
  const std::string svg = drawn(plot);
  for (const char* words : {"30 ms into press", "42 events", "<image"}) EXPECT_TRUE(tells(svg, words)) << words;
  EXPECT_NE(test::error_of([] { frames_plot("Nothing", {}); }).find("none to draw"), std::string::npos);
  frame.raw = cv::Mat();
  EXPECT_NE(test::error_of([&] { frames_plot("Empty", {frame}); }).find("no pair of pictures"), std::string::npos);
}

TEST(FigureText, OfAnyNameIsShownAsItIsAndShortened) {
  const std::string hostile = "<b>'x\"&; system 'ls'";
  const std::string svg = drawn(unseen_plot(hostile, {{hostile, {{.value = 0.9}, {.value = 0.8}, {}}}}));
  EXPECT_TRUE(tells(svg, "&lt;b>")) << svg;
  EXPECT_FALSE(tells(svg, "<b>"));
  EXPECT_EQ(shortened("water-bottle", 20), "water-bottle");
  EXPECT_EQ(shortened("water-bottle", 7), "wat…tle");
  EXPECT_EQ(shortened("µµµµµµ", 3), "µ…µ");
  EXPECT_EQ(shortened("abc", 1), "…");
}

}  // namespace
}  // namespace tactile
