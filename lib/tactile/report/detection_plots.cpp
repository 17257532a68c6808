#include "tactile/report/detection_plots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tactile/core/duration_units.hpp"
#include "tactile/pictures/plot_script.hpp"
#include "tactile/pictures/word_places.hpp"
#include "tactile/report/figure_parts.hpp"

namespace tactile::report {
namespace {

using pictures::figure_colours::ink;

constexpr int curve_left = 76, curve_right = 24, curve_top = 136, delay_bottom = curve_top + 240;
constexpr double x_margin = 0.03;                 // of the axis, on both sides
constexpr double y_below = 0.03, y_above = 0.18;  // of the largest value

/// Press and slip differ without their colours, too.
pictures::LineStyle line_of(Touch touch) {
  return touch == Touch::press
             ? pictures::LineStyle{.colour = pictures::figure_colours::press, .width = 1.6, .mark = 7, .size = 1.1}
             : pictures::LineStyle{.colour = pictures::figure_colours::slip, .width = 1.6, .dashes = 2, .mark = 5, .size = 0.7};
}

/// Of older results, those in none time.
double alarms_per_min(const results::OperatingPoint& point) {
  const double outside = point.outside_labels_per_min.value;
  return std::isfinite(outside) ? outside : point.false_alarms_per_min.value;
}

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
      for (const results::DelaySummary& touch : {point.press, point.slip}) {
        if (std::isfinite(touch.mean_ms.value)) longest_ms = std::max(longest_ms, touch.mean_ms.value);
        if (std::isfinite(touch.missed_share())) most_missed = std::max(most_missed, percent(touch.missed_share()));
      }
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

/// Writes some thresholds next to their points, only where there is room.
void add_thresholds(pictures::PlotScript& script, const CurveAxes& axes, const std::vector<results::OperatingPoint>& points,
                    const std::optional<results::OperatingPoint>& own) {
  constexpr double word_character = 8.5, half_mark = 7, half_own = 18;  // [px]
  pictures::WordPlaces places({.left = curve_left, .top = curve_top, .right = page_width - curve_right, .bottom = delay_bottom});
  const auto take_marks = [&](const results::OperatingPoint& point, double half) {
    const double x = axes.across(point);
    for (const results::DelaySummary& touch : {point.press, point.slip}) {
      const double y = axes.down(touch.mean_ms.value);
      if (std::isfinite(x) && std::isfinite(y)) places.take(x - half, y - half, x + half, y + half);
    }
  };
  for (const results::OperatingPoint& point : points) take_marks(point, half_mark);
  if (own) take_marks(*own, half_own);
  for (std::size_t i = 1; i < points.size(); ++i) {
    const results::OperatingPoint &from = points[i - 1], &to = points[i];
    const double x = axes.across(from), to_x = axes.across(to);
    for (const auto& [from_ms, to_ms] : {std::pair(from.press.mean_ms.value, to.press.mean_ms.value),
                                         std::pair(from.slip.mean_ms.value, to.slip.mean_ms.value)}) {
      if (std::isfinite(x) && std::isfinite(to_x) && std::isfinite(from_ms) && std::isfinite(to_ms))
        places.take_line(x, axes.down(from_ms), to_x, axes.down(to_ms));
    }
  }
  for (const Touch touch : {Touch::slip, Touch::press}) {
    for (const double wanted : {0.5, 0.99, 0.9, 0.999, 0.1}) {
      const auto point = std::find_if(points.begin(), points.end(), [wanted](const results::OperatingPoint& one) {
        return std::abs(one.threshold - wanted) < 1e-9;
      });
      if (point == points.end()) continue;
      const double delay_ms = (touch == Touch::press ? point->press : point->slip).mean_ms.value;
      const std::string words = fmt::format("{:.4g}", wanted);
      const pictures::WordPlaces::Place place =
          places.near(axes.across(*point), axes.down(delay_ms), word_character * static_cast<double>(words.size()));
      if (!place.is_plain()) continue;
      places.take(place);
      script.text(words, place.x, place.y, "center font ',10'", pictures::figure_colours::of(touch));
    }
  }
}

/// One value of press and slip at each point, joined by lines; of the network's own verdicts as diamonds.
template <class ValueOf>
void draw_curves(pictures::PlotScript& script, const CurveAxes& axes, const std::vector<results::OperatingPoint>& points,
                 const std::optional<results::OperatingPoint>& own, ValueOf value_of) {
  const auto add = [&](std::vector<double>& values, const results::OperatingPoint& point) {
    values.insert(values.end(), {axes.place_of(point), value_of(point.press), value_of(point.slip)});
  };
  std::vector<double> values, of_own;
  for (const results::OperatingPoint& point : points) add(values, point);
  if (own) add(of_own, *own);
  const std::string table = script.table(3, std::move(values)), own_table = script.table(3, std::move(of_own));
  const auto press = pictures::figure_colours::press, slip = pictures::figure_colours::slip;
  script.plot({{table, "1:2", "linespoints", line_of(Touch::press)},
               {table, "1:3", "linespoints", line_of(Touch::slip)},
               {own_table, "1:2", "points", {.colour = press, .width = 2.2, .mark = 12, .size = 2.6}},
               {own_table, "1:3", "points", {.colour = slip, .width = 2.2, .mark = 12, .size = 2.6}}});
}

}  // namespace

pictures::Plot operating_curve_plot(const std::string& title, const std::vector<results::OperatingPoint>& points,
                                    const std::optional<results::OperatingPoint>& own) {
  constexpr int gap = 28, missed_height = 120, below = 60, missed_top = delay_bottom + gap, bottom = missed_top + missed_height;
  pictures::PlotHead head(title, page_width);
  head.note("Numbers: probability threshold.");
  head.key("press", line_of(Touch::press));
  head.key("slip", line_of(Touch::slip));
  if (own) head.key("the most probable class, without a threshold", {.colour = ink, .width = 0, .mark = 12, .size = 2});
  pictures::PlotScript script(head, bottom + below);
  std::vector<results::OperatingPoint> all = points;
  if (own) all.push_back(*own);
  const CurveAxes axes(all);
  script.begin_panel({.left = curve_left, .top = curve_top, .right = page_width - curve_right, .bottom = delay_bottom});
  script.axes(axes.x(false), axes.y(axes.longest_ms, "mean delay [ms]"));
  add_thresholds(script, axes, points, own);
  draw_curves(script, axes, points, own, [](const results::DelaySummary& touch) { return touch.mean_ms.value; });
  script.begin_panel({.left = curve_left, .top = missed_top, .right = page_width - curve_right, .bottom = bottom});
  script.axes(axes.x(true), axes.y(axes.most_missed, "missed or early [%]"));
  draw_curves(script, axes, points, own, [](const results::DelaySummary& touch) { return percent(touch.missed_share()); });
  return std::move(script).finished();
}

pictures::Plot detection_curve_plot(const std::string& title, const std::vector<results::DetectedWithin>& press,
                                    const std::vector<results::DetectedWithin>& slip) {
  constexpr int left = 70, right = 24, height = 300, below = 60;
  constexpr double half_ms = 2;  // where the scale turns from even to logarithmic
  const auto place_of = [](double ms) { return std::log10(1 + ms / half_ms); };
  double longest = 10;
  std::vector<pictures::PlotSeries> series;
  Whiskers intervals;
  for (const std::vector<results::DetectedWithin>* curve : {&press, &slip}) {
    for (const results::DetectedWithin& point : *curve) intervals.include(point.share);
  }
  pictures::PlotHead head(title, page_width);
  head.key("press", line_of(Touch::press));
  head.key("slip", line_of(Touch::slip));
  intervals.explain(head);
  const int top = head.bottom() + 16, bottom = top + height;
  pictures::PlotScript script(head, bottom + below);
  script.begin_panel({.left = left, .top = top, .right = page_width - right, .bottom = bottom});
  for (const std::vector<results::DetectedWithin>* curve : {&press, &slip}) {
    const pictures::LineStyle style = line_of(curve == &press ? Touch::press : Touch::slip);
    std::vector<double> values;
    for (const results::DetectedWithin& point : *curve) {
      longest = std::max(longest, point.ms);
      values.insert(values.end(), {place_of(point.ms), percent(point.share.value)});
      add_interval(values, point.share);
    }
    const std::string table = script.table(4, std::move(values));
    if (intervals.any()) {
      for (const std::string_view bound : {"1:3", "1:4"})
        series.push_back({table, bound, "steps", {.colour = style.colour, .width = 0.7}});
    }
    series.push_back({table, "1:2", "steps", {.colour = style.colour, .width = 1.8, .dashes = style.dashes}});
    series.push_back({table, "1:2", "points", {.colour = style.colour, .mark = style.mark, .size = 0.7}});
  }
  std::string tics;
  for (const double ms : {0, 2, 4, 6, 10, 20, 50, 100, 200, 500})
    tics += fmt::format("{}'{:g}' {:.9g}", tics.empty() ? "" : ", ", ms, place_of(ms));
  script.axes({.begin = -0.03 * place_of(longest),
               .end = 1.03 * place_of(longest),
               .label = "time since the onset [ms]; at 0: predicted ahead of it",
               .tics = tics},
              {.begin = 0, .end = 103, .label = "detected [%]"});
  script.plot(series);
  return std::move(script).finished();
}

namespace {

constexpr std::size_t few_objects = 3;  // of a bin that is not drawn where others have more

/// The bins that are drawn: where some have as many as `few_objects`, those with fewer would pass single objects off as all.
results::AccuracyOverTime without_small_bins(results::AccuracyOverTime touch) {
  for (std::vector<results::OverTimeBin>* bins : {&touch.since_onset, &touch.before_end}) {
    const auto is_small = [](const results::OverTimeBin& bin) { return bin.accuracy.n < few_objects; };
    if (!std::all_of(bins->begin(), bins->end(), is_small)) std::erase_if(*bins, is_small);
  }
  return touch;
}

}  // namespace

pictures::Plot over_time_plot(const std::string& title, const results::AccuracyOverTime& all_press,
                              const results::AccuracyOverTime& all_slip) {
  const results::AccuracyOverTime press = without_small_bins(all_press), slip = without_small_bins(all_slip);
  constexpr int left = 66, right = 24, gap = 48, panel_height = 240, below = 60;
  constexpr int width = (page_width - left - right - gap) / 2;
  AccuracyAxis axis;
  Whiskers whiskers;
  for (const results::AccuracyOverTime* touch : {&press, &slip}) {
    for (const std::vector<results::OverTimeBin>* bins : {&touch->since_onset, &touch->before_end}) {
      for (const results::OverTimeBin& bin : *bins) {
        axis.include(bin.accuracy);
        whiskers.include(bin.accuracy);
      }
    }
  }
  pictures::PlotHead head(title, page_width);
  head.key("press", line_of(Touch::press));
  head.key("slip", line_of(Touch::slip));
  whiskers.explain(head);
  const int top = head.bottom() + 40, bottom = top + panel_height;
  pictures::PlotScript script(head, bottom + below);
  for (const bool from_onset : {true, false}) {
    const int begin = from_onset ? left : left + width + gap;
    double longest = 100;
    std::vector<pictures::PlotSeries> series;
    script.begin_panel({.left = begin, .top = top, .right = begin + width, .bottom = bottom});
    for (const results::AccuracyOverTime* touch : {&press, &slip}) {
      pictures::LineStyle bars = line_of(touch == &press ? Touch::press : Touch::slip), line = bars;
      bars.width = 1.2, bars.dashes = 1, bars.size = 0.7;
      line.mark.reset();
      std::vector<double> values;
      for (const results::OverTimeBin& bin : from_onset ? touch->since_onset : touch->before_end) {
        longest = std::max(longest, in_ms(bin.to));
        values.insert(values.end(), {in_ms(bin.from + bin.to) / 2, percent(bin.accuracy.value)});
        add_interval(values, bin.accuracy);
      }
      const std::string table = script.table(4, std::move(values));
      series.push_back({table, "1:2:3:4", "yerrorbars", bars});
      series.push_back({table, "1:2", "lines", line});
    }
    script.text(from_onset ? "since the onset" : "before the end", begin + width / 2.0, top - 16, "center font ',13'");
    script.axes({.begin = from_onset ? 0 : longest,
                 .end = from_onset ? longest : 0,
                 .label = from_onset ? "time since the onset [ms]" : "time before the end [ms]"},
                {.begin = axis.begin(), .end = axis.end(), .label = from_onset ? "correct [%]" : "", .has_labels = from_onset});
    script.plot(series);
  }
  return std::move(script).finished();
}

}  // namespace tactile::report
