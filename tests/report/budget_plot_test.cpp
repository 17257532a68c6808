#include "tactile/report/budget_plot.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "report/plot_rows.hpp"
#include "support/drawn_plot.hpp"

namespace tactile::report {
namespace {

using test::contains;
using test::drawn;
using test::has_row;

/// A setting that has the same values on the runs to choose on.
results::TradedSetting setting(const std::string& kind, const std::string& text, double us, double accuracy) {
  results::TradedSetting made;
  made.values.kind = kind;
  made.text = text;
  made.reported.accuracy = {.value = accuracy, .low = accuracy - 0.01, .high = accuracy + 0.01, .n = 9};
  made.choice.accuracy.value = accuracy;
  made.reported.us_p99.value = made.choice.us_p99.value = us;
  made.reported.whole_runs.median_ms.ms = {.value = 6, .low = 4, .high = 8, .n = 9};
  made.reported.whole_runs.alarms_per_min.value = 9;
  return made;
}

results::Trade two_kinds() {
  results::Trade trade;
  trade.points = {setting("lenet", "as usual", 180, 0.94), setting("lenet", "factor 0.1", 45, 0.90),
                  setting("lenet", "factor 0.1, slower", 49, 0.90), setting("stream", "stream", 9, 0.93),
                  setting("stream", "stream, flip", 30, 0.92)};
  return trade;
}

TEST(BestWithinBudgets, AreTheMostAccurateThatKeepTheLimitOnTheChoiceRuns) {
  results::Trade trade = two_kinds();
  const auto texts = [&] {
    std::vector<std::vector<std::string>> of_kinds;
    for (const BestOfKind& best : best_within_budgets(trade)) {
      of_kinds.push_back({best.kind});
      for (const results::TradedSetting* one : best.within) of_kinds.back().push_back(one == nullptr ? "" : one->text);
    }
    return of_kinds;
  };
  using Texts = std::vector<std::vector<std::string>>;
  EXPECT_EQ(texts(), (Texts{{"lenet", "", "", "factor 0.1", "factor 0.1", "as usual"},
                            {"stream", "", "stream", "stream", "stream", "stream"}}));
  // What the runs to report on show chooses nothing.
  trade.points[0].reported.accuracy.value = 0.1;
  trade.points[0].reported.us_p99.value = 1;
  EXPECT_EQ(texts()[0], (std::vector<std::string>{"lenet", "", "", "factor 0.1", "factor 0.1", "as usual"}));
  trade.points[3].choice.accuracy.value = NAN;
  EXPECT_EQ(texts()[1], (std::vector<std::string>{"stream", "", "", "stream, flip", "stream, flip", "stream, flip"}));
}

TEST(TradeBudgetPlot, ShowsAccuracyDelayAndFalseAlarmsOfEachKindAndNamesTheSettings) {
  const pictures::Plot plot = trade_budget_plot(two_kinds());
  // Two kinds lie side by side; the last limit is at place 4, 10 us at place 1.
  EXPECT_TRUE(has_row(plot, {3.94, 94, 93, 95}));
  EXPECT_TRUE(has_row(plot, {1.06, 93, 92, 94}));
  EXPECT_TRUE(has_row(plot, {1.06, std::log10(7), std::log10(5), std::log10(9)}));
  EXPECT_TRUE(has_row(plot, {1.06, 1, 1, 1})) << "log10(9 + 1), without an interval";
  const std::string svg = drawn(plot);
  for (const char* words : {"accuracy [%]", "median delay, misses included [ms]", "false alarms per minute",
                            "time per tick, at most [us]", "LeNet, from 50 us on: factor 0.1 (45 us)",
                            "LeNet, from 200 us on: as usual (180 us)", "stream, from 10 us on: stream (9 us)"})
    EXPECT_TRUE(contains(svg, words)) << words;
}

TEST(TradeBudgetPlot, IsDrawnWithoutAnySettingToo) {
  EXPECT_TRUE(contains(drawn(trade_budget_plot({})), "accuracy [%]"));
  results::Trade slow;
  slow.points = {setting("lenet", "as usual", 1000, 0.9)};
  EXPECT_TRUE(contains(drawn(trade_budget_plot(slow)), "LeNet: no setting within 200 us"));
}

}  // namespace
}  // namespace tactile::report
