#include "tactile/report/budget_plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tactile/core/text_lines.hpp"
#include "tactile/pictures/plot_script.hpp"
#include "tactile/report/axis_tics.hpp"
#include "tactile/report/figure_parts.hpp"

namespace tactile::report {
namespace {

constexpr int left_margin = 76, right_margin = 20, panels = 3, plot_height = 150, above_plot = 36, under_plot = 30, list_row = 20;
constexpr int width = page_width - left_margin - right_margin;

std::string name_of_kind(const std::string& kind) { return kind == "lenet" ? "LeNet" : kind; }

/// One panel: a figure of a setting, and its axis.
struct Panel {
  const char* label;
  results::Figure (*of)(const results::TradedSetting&);
  bool from_zero;  ///< the axis is linear near 0 and logarithmic beyond
};

constexpr std::array<Panel, panels> all_panels{
    Panel{"accuracy [%]", [](const results::TradedSetting& setting) { return results::scaled(setting.reported.accuracy, 100); },
          false},
    Panel{"median delay, misses included [ms]",
          [](const results::TradedSetting& setting) { return setting.reported.whole_runs.median_ms.ms; }, true},
    Panel{"false alarms per minute",
          [](const results::TradedSetting& setting) { return setting.reported.whole_runs.alarms_per_min; }, true}};

double position_of(double value, const Panel& panel) { return panel.from_zero ? drawn_from_zero(value) : value; }

/// Rows of place, value, low, high. @param aside  added to the place, so that bars of several kinds do not hide each other
std::vector<double> rows_of(const BestOfKind& best, const Panel& panel, double aside) {
  std::vector<double> rows;
  for (std::size_t i = 0; i < tick_budgets.size(); ++i) {
    const results::Figure figure = best.within[i] == nullptr ? results::Figure{} : panel.of(*best.within[i]);
    const double value = best.within[i] == nullptr ? std::numeric_limits<double>::quiet_NaN() : position_of(figure.value, panel);
    const bool has_interval = best.within[i] != nullptr && figure.has_interval();
    rows.insert(rows.end(), {static_cast<double>(i) + aside, value, has_interval ? position_of(*figure.low, panel) : value,
                             has_interval ? position_of(*figure.high, panel) : value});
  }
  return rows;
}

AxisRange range_of(const std::vector<BestOfKind>& all, const Panel& panel) {
  double least = HUGE_VAL, most = -HUGE_VAL;
  for (const BestOfKind& best : all) {
    for (const results::TradedSetting* setting : best.within) {
      if (setting == nullptr) continue;
      const double value = position_of(panel.of(*setting).value, panel);
      if (std::isfinite(value)) least = std::min(least, value), most = std::max(most, value);
    }
  }
  if (least > most) least = most = 0;
  return range_around(least, most, panel.from_zero ? 0.3 : 4, plot_height);
}

/// "LeNet, from 50 us on: factor 0.1, int8", one for each setting of a kind.
std::vector<std::string> names_of(const BestOfKind& best) {
  std::vector<std::string> names;
  const results::TradedSetting* before = nullptr;
  for (std::size_t i = 0; i < tick_budgets.size(); ++i) {
    const results::TradedSetting* setting = best.within[i];
    if (setting == before || setting == nullptr) continue;
    names.push_back(fmt::format("{}, from {:g} us on: {} ({:.0f} us)", name_of_kind(best.kind), tick_budgets[i], setting->text,
                                setting->reported.us_p99.value));
    before = setting;
  }
  if (names.empty()) names.push_back(fmt::format("{}: no setting within {:g} us", name_of_kind(best.kind), tick_budgets.back()));
  return names;
}

std::string budget_tics() {
  std::string tics;
  for (std::size_t i = 0; i < tick_budgets.size(); ++i)
    tics += fmt::format("{}'{:g}' {}", i == 0 ? "" : ", ", tick_budgets[i], i);
  return tics;
}

}  // namespace

std::vector<BestOfKind> best_within_budgets(const results::Trade& trade) {
  std::vector<BestOfKind> all;
  for (const results::TradedSetting& setting : trade.points) {
    auto best = std::find_if(all.begin(), all.end(), [&](const BestOfKind& one) { return one.kind == setting.values.kind; });
    if (best == all.end()) best = all.insert(all.end(), {.kind = setting.values.kind});
    if (!std::isfinite(setting.choice.accuracy.value)) continue;
    for (std::size_t i = 0; i < tick_budgets.size(); ++i) {
      if (!(setting.choice.us_p99.value <= tick_budgets[i])) continue;
      const auto rank = [](const results::TradedSetting& of) {
        return std::pair(of.choice.accuracy.value, -of.choice.us_p99.value);
      };
      if (best->within[i] == nullptr || rank(setting) > rank(*best->within[i])) best->within[i] = &setting;
    }
  }
  return all;
}

pictures::Plot trade_budget_plot(const results::Trade& trade) {
  const std::vector<BestOfKind> all = best_within_budgets(trade);
  constexpr std::size_t name_characters = 66;
  std::vector<std::pair<std::string, std::size_t>> names;  // with the kind
  for (std::size_t kind = 0; kind < all.size(); ++kind) {
    for (const std::string& name : names_of(all[kind])) {
      for (const std::string& line : lines_of(wrapped(name, 4, name_characters))) names.emplace_back(line, kind);
    }
  }
  const std::string title = "The best of each kind of model within a time per tick";
  pictures::PlotHead head(trade.simulated ? title + " (simulated runs)" : title, page_width);
  head.note(
      "The most accurate setting of which 99 % of the ticks take at most this long; chosen on the choice runs, shown on the "
      "reported ones. Below: the settings, with the 99th percentile of their time.");
  Whiskers whiskers;
  for (const BestOfKind& best : all) {
    for (const results::TradedSetting* setting : best.within) {
      for (const Panel& panel : all_panels) whiskers.include(setting == nullptr ? results::Figure{} : panel.of(*setting));
    }
  }
  for (std::size_t kind = 0; kind < all.size(); ++kind) head.key(name_of_kind(all[kind].kind), pictures::line_style(kind));
  whiskers.explain(head);
  if (whiskers.any())
    head.key("it leaves the panel", {.colour = pictures::figure_colours::ink, .width = 0, .mark = 9, .size = 0.9});
  const int first_top = head.bottom() + above_plot, list = first_top + panels * (plot_height + above_plot + under_plot) + 10;
  pictures::PlotScript script(head, list + list_row * static_cast<int>(names.size()) + 10);
  for (std::size_t i = 0; i < names.size(); ++i)
    script.text(names[i].first, 20, list + list_row * static_cast<double>(i), "left font ',12'",
                pictures::line_style(names[i].second).colour);
  for (std::size_t i = 0; i < all_panels.size(); ++i) {
    const Panel& panel = all_panels[i];
    const int top = first_top + static_cast<int>(i) * (plot_height + above_plot + under_plot);
    const AxisRange range = range_of(all, panel);
    script.begin_panel({.left = left_margin, .top = top, .right = left_margin + width, .bottom = top + plot_height});
    script.axes({.begin = -0.5, .end = static_cast<double>(tick_budgets.size()) - 0.5, .tics = budget_tics()},
                {.begin = range.begin,
                 .end = range.end,
                 .tics = panel.from_zero ? decade_tics(range, true, true).text() : std::string()});
    script.text(panel.label, left_margin + width / 2.0, top - 14, "center font ',12'");
    if (i + 1 == all_panels.size())
      script.text("time per tick, at most [us]", left_margin + width / 2.0, top + plot_height + 40, "center font ',12'");
    std::vector<pictures::PlotSeries> series;
    for (std::size_t kind = 0; kind < all.size(); ++kind) {
      const double aside = 0.12 * (static_cast<double>(kind) - static_cast<double>(all.size() - 1) / 2);
      const std::vector<double> rows = rows_of(all[kind], panel, aside);
      const std::string table = script.table(4, rows);
      pictures::LineStyle bars = pictures::line_style(kind), plain = bars;
      bars.dashes = 1;
      plain.mark.reset();
      series.push_back({table, "1:2:3:4", "yerrorbars", bars});
      series.push_back({table, "1:2", "lines", plain});
      for (pictures::PlotSeries& marks : border_marks(script, rows, range, plain)) series.push_back(std::move(marks));
    }
    if (series.empty()) series.push_back({script.table(2, {}), "1:2", "lines", {.colour = pictures::figure_colours::others}});
    script.plot(series);
  }
  return std::move(script).finished();
}

}  // namespace tactile::report
