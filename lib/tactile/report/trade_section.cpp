#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tactile/core/duration_units.hpp"
#include "tactile/report/budget_plot.hpp"
#include "tactile/report/report_page.hpp"
#include "tactile/report/trade_plots.hpp"

namespace tactile::report {
namespace {

constexpr std::size_t most_settings = 80;  // in the table, besides those on a front

/// Those on both fronts first, then those on one, then the others; the most accurate first.
std::vector<results::TradedSetting> by_rank(std::vector<results::TradedSetting> settings) {
  const auto fronts = [](const results::TradedSetting& setting) {
    return (setting.on_accuracy_front ? 1 : 0) + (setting.on_delay_front ? 1 : 0);
  };
  const auto accuracy = [](const results::TradedSetting& setting) {
    return std::isfinite(setting.reported.accuracy.value) ? setting.reported.accuracy.value : -1;
  };
  std::stable_sort(settings.begin(), settings.end(), [&](const results::TradedSetting& a, const results::TradedSetting& b) {
    return std::pair(fronts(a), accuracy(a)) > std::pair(fronts(b), accuracy(b));
  });
  return settings;
}

void add_table(ReportPage& page, const std::vector<results::TradedSetting>& settings) {
  HtmlTable table{
      .caption = "Each setting by its difference from the usual one; below each figure its 95 % interval. trade.json has more",
      .head = {"setting", "accuracy [%]", "median delay [ms]", "missed or early [%]", "false alarms/min", "p50 [us]", "p99 [us]",
               "on the front of"},
      .rows = {},
      .folded = fmt::format("The {} settings in figures", settings.size())};
  std::size_t left_out = 0;
  for (const results::TradedSetting& setting : settings) {
    const bool on_both = setting.on_accuracy_front && setting.on_delay_front;
    if (table.rows.size() >= most_settings && !setting.on_accuracy_front && !setting.on_delay_front) {
      ++left_out;
      continue;
    }
    const results::TradeResult& figures = setting.reported;
    table.rows.push_back({{.text = setting.text},
                          percent_cell(figures.accuracy),
                          figure_cell(figures.whole_runs.median_ms),
                          percent_cell(figures.whole_runs.missed),
                          figure_cell(figures.whole_runs.alarms_per_min),
                          figure_cell(figures.us_p50),
                          figure_cell(figures.us_p99),
                          {.text = on_both                     ? "accuracy, delay"
                                   : setting.on_accuracy_front ? "accuracy"
                                   : setting.on_delay_front    ? "delay"
                                                               : ""}});
  }
  page.html.table(table);
  if (left_out > 0) page.html.paragraph(fmt::format("{} more settings, on no front, are in trade.csv.", left_out));
}

/// In sentences: pairs that do not divide, and what was not measured.
std::vector<std::string> not_in(const results::Trade& trade) {
  std::vector<std::string> sentences;
  for (const results::UntriedPair& pair : trade.left_out)
    sentences.push_back(fmt::format("t_h {:g} ms with a tick of {:g} ms: {}", in_ms(pair.history), in_ms(pair.tick), pair.why));
  for (const results::NotMeasured& one : trade.not_measured) sentences.push_back(fmt::format("{}: {}", one.setting, one.why));
  if (!trade.unfinished.empty()) sentences.push_back(trade.unfinished);
  return sentences;
}

}  // namespace

void add_trade(ReportPage& page, const ReportInput& input) {
  if (!input.trade) return;
  const results::Trade& trade = *input.trade;
  page.html.section("trade", "Speed against accuracy");
  if (trade.simulated && !input.simulated)
    page.html.warning("This part was measured on simulated runs. It says nothing about a real sensor.");
  if (!trade.recommendation.sentence.empty()) page.html.paragraph(trade.recommendation.sentence);
  page.html.paragraph(fmt::format("{} Measured on {}. {}", trade.times_are, trade.cpu(), trade.judged_by));
  const auto on = [&](bool results::TradedSetting::*front) {
    return std::count_if(trade.points.begin(), trade.points.end(),
                         [front](const results::TradedSetting& setting) { return setting.*front; });
  };
  page.figure(
      "trade-accuracy", trade_accuracy_plot(trade),
      fmt::format("Accuracy against time per tick of {} settings, {} of them on the front.", trade.points.size(),
                  on(&results::TradedSetting::on_accuracy_front)),
      "Accuracy against the 99th percentile of the time per tick. The front was found on the choice runs; on the reported "
      "runs it can differ by chance.");
  page.figure(
      "trade-delay", trade_delay_plot(trade),
      fmt::format("Median detection delay against false alarms of {} settings, {} of them on the front.", trade.points.size(),
                  on(&results::TradedSetting::on_delay_front)),
      "Median delay of presses and slips, with the time of computing, against false alarms per minute outside of touches. One "
      "that is missed or early is later than all others; the list has their share.");
  page.figure(
      "trade-budgets", trade_budget_plot(trade),
      "Accuracy, median delay and false alarms of the most accurate setting of each kind of model, within 1, 10, 50, 100 and "
      "200 us per tick.",
      "The most accurate setting of each kind of model whose ticks keep a limit of time, with its accuracy, median delay and "
      "false alarms. It was chosen on the choice runs.");
  add_table(page, by_rank(trade.points));
  for (const std::string& sentence : not_in(trade)) page.missing.push_back("Speed against accuracy: " + sentence);
}

}  // namespace tactile::report
