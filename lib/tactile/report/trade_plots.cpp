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
    dot.x = setting.reported.us_p99.value;
    dot.y = results::scaled(setting.reported.accuracy, 100);
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
    dot.x = setting.reported.whole_runs.alarms_per_min.value;
    dot.y = setting.reported.whole_runs.median_ms.ms;
    dot.on_front = setting.on_delay_front;
    if (std::isfinite(setting.reported.whole_runs.missed.value))
      dot.text += fmt::format(" ({:.1f} % missed or early)", 100 * setting.reported.whole_runs.missed.value);
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

}  // namespace tactile::report
