#include "tactile/report/trade_plots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/pictures/plot_script.hpp"
#include "tactile/report/axis_tics.hpp"
#include "tactile/report/dots_plot.hpp"
#include "tactile/report/figure_parts.hpp"
#include "tactile/results/figure_text.hpp"

namespace tactile::report {
namespace {

using pictures::figure_colours::faint_ink;

std::string titled(const results::Trade& trade, const std::string& words) {
  return trade.simulated ? words + " (simulated runs)" : words;
}

Dot dot_of(const results::TradedSetting& setting) {
  return {
      .usual = setting.design == "usual", .is_single_change = setting.text.find(',') == std::string::npos, .text = setting.text};
}

}  // namespace

pictures::Plot trade_accuracy_plot(const results::Trade& trade) {
  std::vector<Dot> dots;
  for (const results::TradedSetting& setting : trade.points) {
    Dot dot = dot_of(setting);
    dot.x = setting.reported.figures.us_p99.value;
    dot.y = results::scaled(setting.reported.figures.accuracy, 100);
    dot.on_front = setting.on_accuracy_front;
    dots.push_back(std::move(dot));
  }
  return dots_plot(titled(trade, "Accuracy against time per tick"),
                   {.front = "accuracy and time",
                    .bars = "accuracy",
                    .x_label = "99th percentile of the time per tick [us]",
                    .y_label = "accuracy [%]",
                    .least_y_span = 4,
                    .y_end = 100},
                   dots);
}

pictures::Plot trade_delay_plot(const results::Trade& trade) {
  std::vector<Dot> dots;
  for (const results::TradedSetting& setting : trade.points) {
    Dot dot = dot_of(setting);
    dot.x = setting.reported.figures.episodes_per_min.value;
    dot.y = results::scaled(setting.reported.figures.delay_median_us, 1e-3);
    dot.on_front = setting.on_delay_front;
    if (std::isfinite(setting.reported.figures.missed.value))
      dot.text += fmt::format(" ({:.1f} % missed or early)", 100 * setting.reported.figures.missed.value);
    dots.push_back(std::move(dot));
  }
  return dots_plot(titled(trade, "Detection delay against false alarms"),
                   {.front = "false alarms, delay and misses",
                    .bars = "the delay",
                    .x_label = "false alarms per minute, outside of touches",
                    .y_label = "median delay, misses included [ms]",
                    .x_from_zero = true,
                    .y_from_zero = true},
                   dots);
}

namespace {

constexpr int growth_left = 76, growth_right = 20, growth_gap = 40, growth_height = 190, growth_below = 100;
constexpr int growth_width = page_width - growth_left - growth_right;

constexpr std::array<std::pair<const char*, pictures::LineStyle>, 4> growth_lines{
    {{"tactile", {.colour = pictures::figure_colours::network, .width = 1.8, .mark = 7, .size = 0.8}},
     {"its rendering alone", {.colour = pictures::figure_colours::network, .width = 1.4, .dashes = 2, .mark = 6, .size = 0.8}},
     {"every pixel and every output", {.colour = pictures::figure_colours::best, .width = 1.8, .mark = 5, .size = 0.8}},
     {"rendering every pixel", {.colour = pictures::figure_colours::best, .width = 1.4, .dashes = 2, .mark = 4, .size = 0.8}}}};

/// Median times at one point, in the order of the series.
std::array<double, 4> times_of(const results::GrowthPoint& point) {
  return {point.sparse.p50_us, point.sparse.rendering_us, point.dense.p50_us, point.dense.rendering_us};
}

/// A point with its position along a panel; without one where the position is not finite.
struct GrowthStep {
  double position = NAN;
  std::string label;
  const results::GrowthPoint* point = nullptr;
};

struct GrowthPanel {
  std::string label, conditions;
  std::vector<GrowthStep> steps;
};

/// 300k for 300'000, 10M for ten million.
std::string short_number(double value) {
  if (value >= 1e6) return fmt::format("{:g}M", value / 1e6);
  return value >= 1e4 ? fmt::format("{:g}k", value / 1e3) : fmt::format("{:g}", value);
}

/// The positions of the points that have one.
template <class StepOf>
std::vector<GrowthStep> steps_of(const std::vector<results::GrowthPoint>& points, StepOf step_of) {
  std::vector<GrowthStep> steps;
  for (const results::GrowthPoint& point : points) {
    GrowthStep step = step_of(point);
    step.point = &point;
    if (std::isfinite(step.position)) steps.push_back(std::move(step));
  }
  return steps;
}

std::vector<GrowthPanel> panels_of(const results::CostGrowth& growth) {
  // No events at all have a position left of the lowest rate.
  double least_rate = HUGE_VAL;
  for (const results::GrowthPoint& point : growth.by_rate) {
    if (point.events_per_s > 0) least_rate = std::min(least_rate, point.events_per_s);
  }
  const double none_at = std::isfinite(least_rate) ? log_position(least_rate) - 0.6 : 0;
  const auto history_of = [](const results::GrowthPoint& point) { return fmt::format("t_h {:g} ms", in_ms(point.history)); };
  const auto rate_of = [](const results::GrowthPoint& point) { return short_number(point.events_per_s) + " events/s"; };
  const auto sensor_of = [](const results::GrowthPoint& point) {
    return fmt::format("{}x{}", point.sensor.width, point.sensor.height);
  };
  // What is the same at all points.
  const auto conditions = [](const std::vector<results::GrowthPoint>& points, auto first, auto second) {
    return points.empty() ? std::string() : first(points.front()) + ", " + second(points.front());
  };
  return {{.label = "events per second",
           .conditions = conditions(growth.by_rate, history_of, sensor_of),
           .steps = steps_of(growth.by_rate,
                             [&](const results::GrowthPoint& point) {
                               return GrowthStep{point.events_per_s == 0 ? none_at : log_position(point.events_per_s),
                                                 short_number(point.events_per_s)};
                             })},
          {.label = "history t_h [ms]",
           .conditions = conditions(growth.by_history, rate_of, sensor_of),
           .steps = steps_of(growth.by_history,
                             [](const results::GrowthPoint& point) {
                               return GrowthStep{log_position(in_ms(point.history)), fmt::format("{:g}", in_ms(point.history))};
                             })},
          {.label = "pixels of the sensor",
           .conditions = conditions(growth.by_resolution, history_of, rate_of),
           .steps = steps_of(growth.by_resolution, [&](const results::GrowthPoint& point) {
             return GrowthStep{log_position(static_cast<double>(point.sensor.width) * point.sensor.height), sensor_of(point)};
           })}};
}

/// Tics at the steps: level where all labels fit, else at an angle.
pictures::PlotAxis x_axis_of(const GrowthPanel& panel) {
  double first = HUGE_VAL, last = -HUGE_VAL;
  for (const GrowthStep& step : panel.steps) first = std::min(first, step.position), last = std::max(last, step.position);
  const AxisRange range = range_around(first, last, std::log10(4), growth_width);
  AxisTics level(range), at_an_angle(range, true);
  bool all_fit = true;
  for (const GrowthStep& step : panel.steps) {
    // Labels must not leave the figure.
    const double pixel = range.pixel_at(step.position);
    const double half = AxisTics::character * static_cast<double>(characters_in(step.label)) / 2;
    all_fit = level.add({{step.position, step.label}}) && pixel >= half - growth_gap / 2.0 &&
              pixel + half <= growth_width + growth_gap / 2.0 && all_fit;
    if (!at_an_angle.add({{step.position, step.label}})) at_an_angle.add_bare(step.position);
  }
  return {.begin = range.begin,
          .end = range.end,
          .tics = (all_fit ? level : at_an_angle).text(),
          .tic_style = all_fit ? "center" : "rotate by 45 right"};
}

void draw_panel(pictures::PlotScript& script, const GrowthPanel& panel, const pictures::PlotAxis& y, int top) {
  const int bottom = top + growth_height;
  script.begin_panel({.left = growth_left, .top = top, .right = growth_left + growth_width, .bottom = bottom});
  const double middle = growth_left + growth_width / 2.0;
  script.text(panel.label, middle, bottom + 60, "center font ',12'");
  script.text(panel.conditions, middle, bottom + 80, "center font ',11'", faint_ink);
  if (panel.steps.empty()) script.text("not measured", middle, (top + bottom) / 2.0, "center font ',12'", faint_ink);
  script.axes(x_axis_of(panel), y);
  std::vector<double> values;
  for (const GrowthStep& step : panel.steps) {
    values.push_back(step.position);
    for (const double us : times_of(*step.point)) values.push_back(log_position(us));
    // No line from no events to some: their distance on a logarithmic axis means nothing.
    if (step.point->events_per_s <= 0) values.insert(values.end(), 5, NAN);
  }
  const std::string table = script.table(5, std::move(values));
  script.plot({{table, "1:2", "linespoints", growth_lines[0].second},
               {table, "1:3", "linespoints", growth_lines[1].second},
               {table, "1:4", "linespoints", growth_lines[2].second},
               {table, "1:5", "linespoints", growth_lines[3].second}});
}

}  // namespace

pictures::Plot trade_growth_plot(const results::Trade& trade) {
  pictures::PlotHead head(titled(trade, "How the cost of a tick grows"), page_width);
  head.note("Median time per tick [us]");
  for (const auto& [words, style] : growth_lines) head.key(words, style);
  const results::CostGrowth growth = trade.growth.value_or(results::CostGrowth{});
  double most = -HUGE_VAL, least = HUGE_VAL;
  for (const auto* points : {&growth.by_rate, &growth.by_history, &growth.by_resolution}) {
    for (const results::GrowthPoint& point : *points) {
      for (const double us : times_of(point)) {
        const double position = log_position(us);
        if (std::isfinite(position)) most = std::max(most, position), least = std::min(least, position);
      }
    }
  }
  const AxisRange up = range_around(least, most, 1, growth_height);
  const AxisTics tics = decade_tics(up, false, true);
  const std::vector<GrowthPanel> panels = panels_of(growth);
  constexpr int panel_height = growth_height + growth_below;
  int top = head.bottom() + 16;
  pictures::PlotScript script(head, top + static_cast<int>(panels.size()) * panel_height);
  for (const GrowthPanel& panel : panels) {
    draw_panel(script, panel, {.begin = up.begin, .end = up.end, .tics = tics.text()}, top);
    top += panel_height;
  }
  return std::move(script).finished();
}

}  // namespace tactile::report
