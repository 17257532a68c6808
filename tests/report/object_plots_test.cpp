#include "tactile/report/object_plots.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "report/plot_rows.hpp"
#include "support/drawn_plot.hpp"
#include "tactile/pictures/plot_script.hpp"

namespace tactile::report {
namespace {

using test::contains;
using test::drawn;
using test::has_row;

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
  const pictures::Plot plot =
      accuracy_by_history_plot("By history", {curve("fan", {{2, 0.8}, {40, 0.96}}), curve("usb-hub", {{2, 0.85}, {40, 0.84}})});
  EXPECT_TRUE(has_row(plot, {2, 80, 79, 81}));
  EXPECT_TRUE(has_row(plot, {40, 84, 83, 85}));
  EXPECT_TRUE(has_row(plot, {40, 96}));  // the best of the fan, marked
  EXPECT_TRUE(has_row(plot, {2, 85}));   // that of the hub
  const std::string svg = drawn(plot);
  for (const char* words : {"By history", "fan", "usb-hub", "accuracy [%]", "history t_h [ms]"})
    EXPECT_TRUE(contains(svg, words)) << words;
}

TEST(AccuracyByHistoryPlot, BearsWhatIsMissingManyObjectsAndLongNames) {
  drawn(accuracy_by_history_plot("Nothing", {}));
  drawn(accuracy_by_history_plot("Unmeasured", {curve("fan", {{2, NAN}, {40, NAN}})}));
  std::vector<HistoryCurve> many(100, curve(std::string(300, 'm'), {{2, 0.5}, {40, 0.9}}));
  const std::string svg = drawn(accuracy_by_history_plot("Many", many));
  EXPECT_TRUE(contains(svg, "The first 60 of 100 are shown."));
  EXPECT_FALSE(contains(svg, std::string(30, 'm')));
}

TEST(DelayPlot, HoldsBarsWhiskersAndWhatWasMissed) {
  const pictures::Plot plot = delay_plot(
      "Delays", {"fan", "usb-hub"}, {{"fan", {.mean_ms = {.value = 4}, .sem_ms = 0.5, .intervals = 9, .misses = 1, .early = 2}}},
      {{"fan", {.mean_ms = {.value = 2}, .sem_ms = 0, .intervals = 9}}, {"usb-hub", {.intervals = 3, .misses = 3}}});
  EXPECT_TRUE(has_row(plot, {2, 1, 0, 4, 0.68, 1.32}));  // the fan, on top: its bar from 0 to 4
  EXPECT_TRUE(has_row(plot, {4, 1, 3.5, 4.5}));
  EXPECT_TRUE(has_row(plot, {2, 1, 2, 2}));
  const std::string svg = drawn(plot);
  for (const char* words : {"press", "slip", "fan", "usb-hub", "4.0, 1 missed, 2 early", "none, 3 missed", "no interval", "5 ms"})
    EXPECT_TRUE(contains(svg, words)) << words;
  drawn(delay_plot("Nothing", {}, {}, {}));
}

TEST(UnseenPlot, HoldsBothAccuraciesOfEachObject) {
  const pictures::Plot plot = unseen_plot("Unseen", {{"fan", {{0.97, 0.96, 0.98, 9}, {0.90, 0.85, 0.94, 9}, {}}},
                                                     {"sprayer", {{.value = 0.99}, {.value = 0.5}, {}}}});
  EXPECT_TRUE(has_row(plot, {97, 1.14, 96, 98}));
  EXPECT_TRUE(has_row(plot, {90, 0.86, 85, 94}));
  EXPECT_TRUE(has_row(plot, {99, 0.14, 99, 99}));  // without an interval: a point
  const std::string svg = drawn(plot);
  EXPECT_TRUE(contains(svg, "sprayer"));
  EXPECT_TRUE(contains(svg, "95 % interval, where there is one"));
  const results::Figure bounded{0.97, 0.96, 0.98, 9}, single{.value = 0.5};
  EXPECT_TRUE(contains(drawn(unseen_plot("All", {{"fan", {bounded, bounded, {}}}})), ">95 % interval<"));
  const std::string without = drawn(unseen_plot("None", {{"fan", {single, single, {}}}}));
  EXPECT_TRUE(contains(without, "No intervals: they need 3 runs or objects, and 1 training or 3."));
  EXPECT_FALSE(contains(without, "95 %"));
  drawn(unseen_plot("Nothing", {}));
}

TEST(Captions, MentionIntervalsAndWhiskersOnlyWhereThereAreSome) {
  const HistoryCurve bare{.name = "fan", .points = {{.history_ms = 2, .accuracy = {.value = 0.9, .n = 1}}}};
  const std::string without = drawn(accuracy_by_history_plot("By history", {bare}));
  EXPECT_FALSE(contains(without, "95 %"));
  EXPECT_TRUE(contains(without, "No intervals: they need 3 runs"));
  EXPECT_TRUE(contains(drawn(accuracy_by_history_plot("By history", {bare, curve("hub", {{2, 0.8}})})), "where there is one"));
  EXPECT_FALSE(
      contains(drawn(delay_plot("Delays", {"fan"}, {{"fan", {.mean_ms = {.value = 4}, .intervals = 1}}}, {})), "standard error"));
  EXPECT_TRUE(
      contains(drawn(delay_plot("Delays", {"fan"}, {{"fan", {.mean_ms = {.value = 4}, .sem_ms = 1, .intervals = 2}}}, {})),
               "standard error"));
}

TEST(FigureText, OfAnyNameIsShownAsItIsAndShortened) {
  const std::string hostile = "<b>'x\"&; system 'ls'";
  const std::string svg = drawn(unseen_plot(hostile, {{hostile, {{.value = 0.9}, {.value = 0.8}, {}}}}));
  EXPECT_TRUE(contains(svg, "&lt;b>")) << svg;
  EXPECT_FALSE(contains(svg, "<b>"));
  EXPECT_EQ(pictures::shortened("water-bottle", 20), "water-bottle");
  EXPECT_EQ(pictures::shortened("water-bottle", 7), "wat…tle");
  EXPECT_EQ(pictures::shortened("µµµµµµ", 3), "µ…µ");
  EXPECT_EQ(pictures::shortened("abc", 1), "…");
}

}  // namespace
}  // namespace tactile::report
