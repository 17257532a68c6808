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
                   {.front = "not beaten in both by any other setting",
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
                   {.front = "not beaten in false alarms, delay and misses together by any other setting",
                    .bars = "the delay",
                    .x_label = "false alarms per minute, outside labels",
                    .y_label = "median delay, misses included [ms]",
                    .x_from_zero = true,
                    .y_from_zero = true},
                   dots);
}

namespace {

constexpr int growth_left = 70, growth_right = 20, growth_top = 122, growth_gap = 28, growth_height = 330;
constexpr int growth_bottom = growth_top + growth_height;

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
  int left = 0, width = 0;
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
  constexpr std::array<int, 3> widths{384, 200, 270};  // a panel with more labels is wider
  static_assert(growth_left + widths[0] + widths[1] + widths[2] + 2 * growth_gap + growth_right == page_width);
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
  std::vector<GrowthPanel> panels{
      {.label = "events per second",
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
  int begin = growth_left;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    panels[i].left = begin, panels[i].width = widths[i];
    begin += widths[i] + growth_gap;
  }
  return panels;
}

/// Tics at the steps: level where all labels fit, else at an angle.
pictures::PlotAxis x_axis_of(const GrowthPanel& panel) {
  double first = HUGE_VAL, last = -HUGE_VAL;
  for (const GrowthStep& step : panel.steps) first = std::min(first, step.position), last = std::max(last, step.position);
  const AxisRange range = range_around(first, last, std::log10(4), panel.width);
  AxisTics level(range), at_an_angle(range, true);
  bool all_fit = true;
  for (const GrowthStep& step : panel.steps) {
    // Labels must not reach into the next panel.
    const double pixel = range.pixel_at(step.position);
    const double half = AxisTics::character * static_cast<double>(characters_in(step.label)) / 2;
    all_fit = level.add({{step.position, step.label}}) && pixel >= half - growth_gap / 2.0 &&
              pixel + half <= panel.width + growth_gap / 2.0 && all_fit;
    if (!at_an_angle.add({{step.position, step.label}})) at_an_angle.add_bare(step.position);
  }
  return {.begin = range.begin,
          .end = range.end,
          .tics = (all_fit ? level : at_an_angle).text(),
          .tic_style = all_fit ? "center" : "rotate by 45 right"};
}

void draw_panel(pictures::PlotScript& script, const GrowthPanel& panel, const pictures::PlotAxis& y) {
  script.begin_panel({.left = panel.left, .top = growth_top, .right = panel.left + panel.width, .bottom = growth_bottom});
  const double middle = panel.left + panel.width / 2.0;
  script.text(panel.label, middle, growth_bottom + 84, "center font ',12'");
  script.text(panel.conditions, middle, growth_bottom + 105, "center font ',11'", faint_ink);
  if (panel.steps.empty())
    script.text("not measured", middle, (growth_top + growth_bottom) / 2.0, "center font ',12'", faint_ink);
  script.axes(x_axis_of(panel), y);
  std::vector<double> values;
  for (const GrowthStep& step : panel.steps) {
    values.push_back(step.position);
    for (const double us : times_of(*step.point)) values.push_back(log_position(us));
    // No line from no events to some: their distance on a logarithmic axis means nothing.
    if (step.point->events_per_s <= 0) values.insert(values.end(), 5, NAN);
  }
  const std::string table = script.table(5, std::move(values));
  const auto ours = pictures::figure_colours::network, dense = pictures::figure_colours::best;
  script.plot({{table, "1:2", "linespoints", {.colour = ours, .width = 1.8, .mark = 7, .size = 0.8}},
               {table, "1:3", "linespoints", {.colour = ours, .width = 1.4, .dashes = 2, .mark = 6, .size = 0.8}},
               {table, "1:4", "linespoints", {.colour = dense, .width = 1.8, .mark = 5, .size = 0.8}},
               {table, "1:5", "linespoints", {.colour = dense, .width = 1.4, .dashes = 2, .mark = 4, .size = 0.8}}});
}

}  // namespace

pictures::Plot trade_growth_plot(const results::Trade& trade) {
  constexpr int below = 124;
  pictures::PlotScript script(titled(trade, "How the cost of a tick grows"), page_width, growth_bottom + below);
  script.note("Blue circles: tactile, the whole tick; hollow and dashed: its rendering alone. Orange squares: the dense method,");
  script.note("which computes every pixel and every output of the network.");
  script.text("median time per tick [us]", 20, 100, "left font ',12'");
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
  for (const GrowthPanel& panel : panels)
    draw_panel(script, panel, {.begin = up.begin, .end = up.end, .tics = tics.text(&panel == &panels.front())});
  return std::move(script).finished();
}

}  // namespace tactile::report
