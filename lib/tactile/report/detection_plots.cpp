#include "tactile/report/detection_plots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tactile/pictures/plot_script.hpp"
#include "tactile/pictures/word_places.hpp"
#include "tactile/report/figure_parts.hpp"

namespace tactile::report {
namespace {

using pictures::figure_colours::ink;

constexpr int curve_left = 76, curve_right = 24, curve_top = 136, delay_bottom = curve_top + 240;
constexpr double longest_shown_ms = 100;          // delays beyond it are drawn at it
constexpr double x_margin = 0.03;                 // of the axis, on both sides
constexpr double y_below = 0.03, y_above = 0.18;  // of the largest value

/// Of all touches; for the median and for 90 % of them.
pictures::LineStyle line_of_quantile(bool median) {
  return median
             ? pictures::LineStyle{.colour = pictures::figure_colours::press, .width = 1.6, .mark = 7, .size = 0.9}
             : pictures::LineStyle{.colour = pictures::figure_colours::slip, .width = 1.6, .dashes = 2, .mark = 5, .size = 0.6};
}

double alarms_per_min(const results::OperatingPoint& point) { return point.alarms_per_min.value; }

/// The axes of the figure. False alarms span decades: their logarithm is drawn, and no alarms at all have a place on the left.
struct CurveAxes {
  double begin = 0, end = 1, none_at = 0;  ///< log10 of false alarms per minute
  double longest_ms = 0, most_missed = 5;  ///< [%]

  explicit CurveAxes(const std::vector<results::OperatingPoint>& points) {
    double most_alarms = 0, least_alarms = 1e9;
    for (const results::OperatingPoint& point : points) {
      if (const double alarms = alarms_per_min(point); std::isfinite(alarms) && alarms > 0) {
        most_alarms = std::max(most_alarms, alarms);
        least_alarms = std::min(least_alarms, alarms);
      }
      for (const results::CensoredQuantile* delay : {&point.median_ms, &point.p90_ms}) {
        if (std::isfinite(delay->ms.value)) longest_ms = std::max(longest_ms, std::min(delay->ms.value, longest_shown_ms));
      }
      if (std::isfinite(point.missed.value)) most_missed = std::max(most_missed, percent(point.missed.value));
    }
    if (most_alarms <= 0) most_alarms = least_alarms = 1;
    if (longest_ms <= 0) longest_ms = 1;
    begin = std::floor(std::log10(least_alarms));
    end = std::max(begin + 1, std::ceil(std::log10(most_alarms)));
    none_at = begin - 0.12 * (end - begin);
  }

  double span() const { return end - none_at; }
  double place_of(const results::OperatingPoint& point) const {
    const double alarms = alarms_per_min(point);
    return alarms > 0 ? std::log10(alarms) : alarms == 0 ? none_at : alarms;
  }
  pictures::PlotAxis x(bool has_labels) const {
    std::string tics = fmt::format("'{}' {:.9g}", has_labels ? "none" : "", none_at);
    for (int decade = static_cast<int>(begin); decade <= end; ++decade)
      tics += fmt::format(", '{}' {}", has_labels ? fmt::format("{:g}", std::pow(10, decade)) : "", decade);
    return {.begin = none_at - x_margin * span(),
            .end = end + x_margin * span(),
            .label = has_labels ? "false alarms per minute" : "",
            .tics = tics};
  }
  static pictures::PlotAxis y(double most, std::string_view label) {
    return {.begin = -y_below * most, .end = (1 + y_above) * most, .label = label};
  }

  // In pixels of the panel of delays.
  double across(const results::OperatingPoint& point) const {
    return curve_left + (page_width - curve_left - curve_right) * (place_of(point) - none_at + x_margin * span()) /
                            ((1 + 2 * x_margin) * span());
  }
  double down(double delay_ms) const {
    return delay_bottom - (delay_bottom - curve_top) * (delay_ms + y_below * longest_ms) / ((1 + y_below + y_above) * longest_ms);
  }
};

/// Writes some thresholds next to the points of the median, only where there is room.
void add_thresholds(pictures::PlotScript& script, const CurveAxes& axes, const std::vector<results::OperatingPoint>& points) {
  constexpr double word_character = 8.5, half_mark = 7;  // [px]
  pictures::WordPlaces places({.left = curve_left, .top = curve_top, .right = page_width - curve_right, .bottom = delay_bottom});
  const auto place_of = [&](const results::OperatingPoint& point, const results::CensoredQuantile& delay) {
    return std::pair(axes.across(point), axes.down(std::min(delay.ms.value, longest_shown_ms)));
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (const auto quantile : {&results::OperatingPoint::median_ms, &results::OperatingPoint::p90_ms}) {
      const auto [x, y] = place_of(points[i], points[i].*quantile);
      if (!std::isfinite(x) || !std::isfinite(y)) continue;
      places.take(x - half_mark, y - half_mark, x + half_mark, y + half_mark);
      if (i == 0) continue;
      const auto [from_x, from_y] = place_of(points[i - 1], points[i - 1].*quantile);
      if (std::isfinite(from_x) && std::isfinite(from_y)) places.take_line(from_x, from_y, x, y);
    }
  }
  for (const double wanted : {1.5, 4.0, 8.0, 0.0, 12.0, -2.0}) {
    const auto point = std::find_if(points.begin(), points.end(), [wanted](const results::OperatingPoint& one) {
      return one.threshold && std::abs(*one.threshold - wanted) < 1e-9;
    });
    if (point == points.end()) continue;
    const auto [x, y] = place_of(*point, point->median_ms);
    const std::string words = fmt::format("{:g}", wanted);
    const pictures::WordPlaces::Place place = places.near(x, y, word_character * static_cast<double>(words.size()));
    if (!place.is_plain()) continue;
    places.take(place);
    script.text(words, place.x, place.y, "center font ',10'", pictures::figure_colours::press);
  }
}

}  // namespace

pictures::Plot operating_curve_plot(const std::string& title, const std::vector<results::OperatingPoint>& points,
                                    const std::optional<results::OperatingPoint>& own) {
  constexpr int gap = 28, missed_height = 120, below = 60, missed_top = delay_bottom + gap, bottom = missed_top + missed_height;
  pictures::PlotHead head(title, page_width);
  head.note("Numbers: the threshold on the log-odds.");
  head.key("half of the touches", line_of_quantile(true));
  head.key("90 %", line_of_quantile(false));
  if (own) head.key("the verdicts as they were decided", {.colour = ink, .width = 0, .mark = 12, .size = 2});
  pictures::PlotScript script(head, bottom + below);
  std::vector<results::OperatingPoint> all = points;
  if (own) all.push_back(*own);
  const CurveAxes axes(all);
  const auto rows_of = [&](const std::vector<results::OperatingPoint>& of) {
    std::vector<double> rows;
    for (const results::OperatingPoint& point : of)
      rows.insert(rows.end(), {axes.place_of(point), std::min(point.median_ms.ms.value, longest_shown_ms),
                               std::min(point.p90_ms.ms.value, longest_shown_ms), percent(point.missed.value)});
    return rows;
  };
  const std::string table = script.table(4, rows_of(points));
  const std::string own_table = script.table(4, own ? rows_of({*own}) : std::vector<double>());
  const auto diamond = [](std::string_view colour) {
    return pictures::LineStyle{.colour = colour, .width = 2.2, .mark = 12, .size = 2.6};
  };
  script.begin_panel({.left = curve_left, .top = curve_top, .right = page_width - curve_right, .bottom = delay_bottom});
  script.axes(axes.x(false), axes.y(axes.longest_ms, "delay [ms]"));
  add_thresholds(script, axes, points);
  script.plot({{table, "1:2", "linespoints", line_of_quantile(true)},
               {table, "1:3", "linespoints", line_of_quantile(false)},
               {own_table, "1:2", "points", diamond(pictures::figure_colours::press)},
               {own_table, "1:3", "points", diamond(pictures::figure_colours::slip)}});
  script.begin_panel({.left = curve_left, .top = missed_top, .right = page_width - curve_right, .bottom = bottom});
  script.axes(axes.x(true), axes.y(axes.most_missed, "missed or early [%]"));
  script.plot({{table, "1:4", "linespoints", {.colour = ink, .width = 1.6, .mark = 7, .size = 0.9}},
               {own_table, "1:4", "points", diamond(ink)}});
  return std::move(script).finished();
}

pictures::Plot settings_curve_plot(const std::string& title, const std::vector<SettingCurve>& settings) {
  constexpr int gap = 56, height = 200, below = 60;
  std::vector<results::OperatingPoint> all;
  for (const SettingCurve& setting : settings) all.insert(all.end(), setting.points.begin(), setting.points.end());
  const CurveAxes axes(all);
  const auto style_of = [](const SettingCurve& setting) {
    return pictures::LineStyle{.colour = setting.is_stream ? pictures::figure_colours::slip : pictures::figure_colours::press,
                               .width = 1.6,
                               .dashes = setting.is_unseen ? 2 : 1,
                               .mark = setting.is_unseen ? 6 : 7,
                               .size = 0.7};
  };
  pictures::PlotHead head(title, page_width);
  for (const SettingCurve& setting : settings) head.key(setting.name, style_of(setting));
  const int top = head.bottom() + 40, second = top + height + gap, bottom = second + height;
  pictures::PlotScript script(head, bottom + below);
  std::vector<std::string> tables;
  for (const SettingCurve& setting : settings) {
    std::vector<double> rows;
    for (const results::OperatingPoint& point : setting.points)
      rows.insert(rows.end(), {axes.place_of(point), std::min(point.median_ms.ms.value, longest_shown_ms),
                               std::min(point.p90_ms.ms.value, longest_shown_ms)});
    tables.push_back(script.table(3, std::move(rows)));
  }
  for (const bool is_median : {true, false}) {
    const int from = is_median ? top : second;
    script.begin_panel({.left = curve_left, .top = from, .right = page_width - curve_right, .bottom = from + height});
    script.text(is_median ? "half of the touches" : "90 % of the touches", page_width / 2.0, from - 16, "center font ',13'");
    script.axes(axes.x(!is_median), axes.y(axes.longest_ms, "delay [ms]"));
    std::vector<pictures::PlotSeries> series;
    for (std::size_t i = 0; i < settings.size(); ++i)
      series.push_back({tables[i], is_median ? "1:2" : "1:3", "linespoints", style_of(settings[i])});
    script.plot(series);
  }
  return std::move(script).finished();
}

}  // namespace tactile::report
