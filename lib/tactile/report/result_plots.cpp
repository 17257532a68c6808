#include "tactile/report/result_plots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "tactile/report/plot_script.hpp"
#include "tactile/report/word_places.hpp"

namespace tactile {
namespace {

using figure_colours::faint_ink;
using figure_colours::ink;

constexpr int page_width = 1000;         // [px]
constexpr std::size_t most_panels = 60;  // of small panels, and of rows

double percent(double share) { return 100 * share; }

double in_ms(microseconds us) { return static_cast<double>(us.count()) / 1000; }

/// The greatest whole ten below everything that is to be seen, and 90 at most: axes of accuracy end at 100.
class AccuracyAxis {
 public:
  void include(const Figure& accuracy) {
    for (const double value : {accuracy.value, accuracy.low.value_or(NAN)}) {
      if (std::isfinite(value)) least_ = std::min(least_, percent(value));
    }
  }
  double begin() const { return std::clamp(10 * std::floor((least_ - 1) / 10), 0.0, 90.0); }
  double end() const { return 100 + 0.03 * (100 - begin()); }

 private:
  double least_ = 100;
};

/// What the whiskers of a figure are, if it has any.
std::string whiskers_in_words(std::size_t with_interval, std::size_t drawn) {
  if (with_interval == 0) return " No interval for want of three to draw from.";
  return with_interval < drawn ? " Whiskers: 95 % intervals where three could be drawn." : " Whiskers: 95 % intervals.";
}

/// The interval, or the value twice where there is none: gnuplot leaves out a point whose interval is a gap.
void add_interval(std::vector<double>& values, const Figure& measured) {
  values.push_back(percent(measured.has_interval() ? *measured.low : measured.value));
  values.push_back(percent(measured.has_interval() ? *measured.high : measured.value));
}

std::string left_out(std::size_t there, std::size_t shown) {
  return there > shown ? fmt::format("The first {} of {} are shown. ", shown, there) : std::string();
}

/// Names of the rows, the first on top, as tics of the y axis.
std::string row_names(const std::vector<std::string>& names) {
  std::string tics;
  for (std::size_t i = 0; i < names.size(); ++i)
    tics += fmt::format("{}{} {}", i == 0 ? "" : ", ", plot_text(shortened(names[i], 22)), names.size() - 1 - i);
  return tics.empty() ? "'' 0" : tics;
}

/// 1, 2 and 5 of each decade within [least, most], as tics of an axis of logarithms.
std::string decade_tics(double least, double most) {
  std::string tics;
  for (int decade = static_cast<int>(std::floor(std::log10(least))); decade <= static_cast<int>(std::ceil(std::log10(most)));
       ++decade) {
    for (const int step : {1, 2, 5}) {
      const double value = step * std::pow(10, decade);
      if (value >= least && value <= most) tics += fmt::format("{}{:.9g}", tics.empty() ? "" : ", ", value);
    }
  }
  return tics;
}

}  // namespace

std::vector<HistoryCurve::Point>::const_iterator best_of(const HistoryCurve& curve) {
  auto best = curve.points.end();
  for (auto point = curve.points.begin(); point != curve.points.end(); ++point) {
    if (std::isfinite(point->accuracy.value) && (best == curve.points.end() || point->accuracy.value > best->accuracy.value))
      best = point;
  }
  return best;
}

Plot accuracy_by_history_plot(const std::string& title, const std::vector<HistoryCurve>& curves) {
  constexpr int columns = 4, left = 70, right = 20, top = 114, gap = 22, panel_height = 150, row_height = 212, below = 30;
  const std::size_t shown = std::min(curves.size(), most_panels);
  const int rows = std::max(1, (static_cast<int>(shown) + columns - 1) / columns);
  PlotScript script(title, page_width, top + rows * row_height + below);
  AccuracyAxis axis;
  std::set<double> histories;
  for (const HistoryCurve& curve : curves) {
    for (const HistoryCurve::Point& point : curve.points) {
      axis.include(point.accuracy);
      histories.insert(point.history_ms);
    }
  }
  const double longest = histories.empty() ? 50 : *histories.rbegin();
  std::string tics;
  if (histories.size() <= 8) {
    for (const double history : histories) tics += fmt::format("{}{:g}", tics.empty() ? "" : ", ", history);
  }

  std::size_t with_interval = 0;
  for (const HistoryCurve& curve : curves) {
    with_interval += std::any_of(curve.points.begin(), curve.points.end(),
                                 [](const HistoryCurve::Point& point) { return point.accuracy.has_interval(); })
                         ? 1U
                         : 0U;
  }
  script.text(left_out(curves.size(), shown) +
                  (with_interval == 0              ? "Blue: the panel's own, no interval for want of three runs; "
                   : with_interval < curves.size() ? "Blue: the panel's own, with its 95 % interval where three could be drawn; "
                                                   : "Blue: the panel's own, with its 95 % interval; ") +
                  "grey: the others. Orange: its best history.",
              20, 52, "left font ',12'", faint_ink);
  script.text("accuracy [%]", 20, 76, "left font ',12'");
  script.text("history t_h [ms]", page_width / 2.0, top + rows * row_height + 8, "center font ',12'");
  std::vector<std::string> tables;
  for (const HistoryCurve& curve : curves) {
    std::vector<double> values;
    for (const HistoryCurve::Point& point : curve.points) {
      values.push_back(point.history_ms);
      values.push_back(percent(point.accuracy.value));
      add_interval(values, point.accuracy);
    }
    tables.push_back(script.table(4, std::move(values)));
  }
  const int width = (page_width - left - right - (columns - 1) * gap) / columns;
  for (std::size_t i = 0; i < shown; ++i) {
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    const PlotBox box{.left = left + column * (width + gap),
                      .top = top + row * row_height,
                      .right = left + column * (width + gap) + width,
                      .bottom = top + row * row_height + panel_height};
    script.begin_panel(box);
    script.text(shortened(curves[i].name, 26), (box.left + box.right) / 2.0, box.top - 12, "center font ',12'");
    script.add("set xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]", -0.03 * longest, 1.06 * longest, axis.begin(),
               axis.end());
    if (!tics.empty()) script.add("set xtics ({})", tics);
    if (column > 0) script.add("set format y ''");
    std::string lines;
    for (std::size_t other = 0; other < shown; ++other) {
      if (other != i)
        lines += fmt::format("{} using 1:2 with lines lc rgb '{}' lw 1 notitle, ", tables[other], figure_colours::others);
    }
    lines += fmt::format(
        "{0} using 1:2:3:4 with yerrorbars lc rgb '{1}' lw 1.4 dt 1 pt 7 ps 0.7 notitle, "
        "{0} using 1:2 with lines lc rgb '{1}' lw 2.2 notitle",
        tables[i], figure_colours::network);
    if (const auto best = best_of(curves[i]); best != curves[i].points.end()) {
      lines += fmt::format(", {} using 1:2 with points lc rgb '{}' pt 13 ps 1.5 notitle",
                           script.table(2, {best->history_ms, percent(best->accuracy.value)}), figure_colours::best);
    }
    script.add("plot {}", lines);
  }
  if (shown == 0) {
    script.begin_panel({.left = left, .top = top, .right = left + width, .bottom = top + panel_height});
    script.add("set xrange [0:50]\nset yrange [0:100]\nplot {} notitle", script.table(2, {}));
  }
  return std::move(script).plot();
}

namespace {

bool has_whiskers(const std::map<std::string, DelaySummary>& bars) {
  return std::any_of(bars.begin(), bars.end(), [](const auto& bar) { return std::isfinite(bar.second.sem_ms); });
}

}  // namespace

Plot delay_plot(const std::string& title, const std::vector<std::string>& objects,
                const std::map<std::string, DelaySummary>& press, const std::map<std::string, DelaySummary>& slip,
                double limit_ms) {
  constexpr int left = 200, right = 24, top = 106, gap = 30, row_height = 30, below = 62;
  constexpr double note_share = 0.5;  // of a panel's width, for what is told beside the bars
  const std::size_t shown = std::min(objects.size(), most_panels);
  const std::vector<std::string> names(objects.begin(), objects.begin() + static_cast<std::ptrdiff_t>(shown));
  const int bottom = top + static_cast<int>(std::max<std::size_t>(shown, 1)) * row_height;
  PlotScript script(title, page_width, bottom + below);
  script.text(left_out(objects.size(), shown) +
                  fmt::format("Bars: mean over detected intervals; {}dashed: {:g} ms, which the paper stays below.",
                              has_whiskers(press) || has_whiskers(slip) ? "whiskers: standard error; " : "", limit_ms),
              20, 52, "left font ',12'", faint_ink);
  const int width = (page_width - left - right - gap) / 2;
  for (const Touch touch : {Touch::press, Touch::slip}) {
    const bool is_press = touch == Touch::press;
    const auto& bars = is_press ? press : slip;
    const int begin = is_press ? left : left + width + gap;
    script.begin_panel({.left = begin, .top = top, .right = begin + width, .bottom = bottom});
    script.text(std::string(name_of(touch)), begin + width / 2.0, top - 16, "center font ',13'", figure_colours::of(touch));
    double longest = limit_ms;
    std::vector<double> boxes, whiskers;
    for (std::size_t i = 0; i < shown; ++i) {
      const auto found = bars.find(names[i]);
      const auto y = static_cast<double>(shown - 1 - i);
      if (found == bars.end() || !std::isfinite(found->second.mean_ms.value)) continue;
      const double mean = found->second.mean_ms.value, sem = found->second.sem_ms;
      for (const double value : {mean / 2, y, std::min(0.0, mean), std::max(0.0, mean), y - 0.32, y + 0.32})
        boxes.push_back(value);
      if (std::isfinite(sem)) {
        for (const double value : {mean, y, mean - sem, mean + sem}) whiskers.push_back(value);
      }
      longest = std::max(longest, mean + (std::isfinite(sem) ? sem : 0));
    }
    const double bars_end = 1.04 * longest, end = bars_end / (1 - note_share);
    for (std::size_t i = 0; i < shown; ++i) {
      const auto found = bars.find(names[i]);
      std::string note = "no interval";
      if (found != bars.end() && found->second.intervals > 0) {
        const DelaySummary& bar = found->second;
        note = std::isfinite(bar.mean_ms.value) ? fmt::format("{:.1f}", bar.mean_ms.value) : "none";
        if (bar.misses > 0) note += fmt::format(", {} missed", bar.misses);
        if (bar.early > 0) note += fmt::format(", {} early", bar.early);
      }
      script.add("set label {} at graph {:.4f}, first {} left font ',10' textcolor rgb '{}' front", plot_text(note),
                 1 - note_share + 0.03, shown - 1 - i, ink);
    }
    script.add("set xrange [0:{:.9g}]\nset yrange [-0.6:{:.9g}]", end, static_cast<double>(shown) - 0.4);
    script.add("set ytics ({}) scale 0", row_names(names));
    if (!is_press) script.add("set format y ''\nset ytics ('' 0)");
    script.add("unset grid\nset grid x lt 1 lc rgb '{}' lw 0.6", figure_colours::grid);
    script.add("set arrow from first {0:.9g}, graph 0 to first {0:.9g}, graph 1 nohead dt 2 lc rgb '{1}' lw 1.2 front", limit_ms,
               ink);
    // Tics end where the words begin.
    const double step = std::pow(10, std::floor(std::log10(bars_end / 2)));
    script.add("set xtics 0, {:.9g}, {:.9g}", bars_end / step > 10 ? 5 * step : bars_end / step > 5 ? 2 * step : step, bars_end);
    script.add("set xlabel 'detection delay [ms]' textcolor rgb '{}'", ink);
    script.add(
        "plot {} using 1:2:3:4:5:6 with boxxyerror fs solid 0.75 noborder lc rgb '{}' notitle, "
        "{} using 1:2:3:4 with xerrorbars lc rgb '{}' lw 1.6 pt 0 notitle",
        script.table(6, std::move(boxes)), figure_colours::of(touch), script.table(4, std::move(whiskers)), ink);
  }
  return std::move(script).plot();
}

Plot unseen_plot(const std::string& title, const std::map<std::string, SeenAndHeldOut>& objects) {
  constexpr int left = 200, right = 30, top = 84, row_height = 54, below = 62;
  const std::size_t shown = std::min(objects.size(), most_panels);
  const int bottom = top + static_cast<int>(std::max<std::size_t>(shown, 1)) * row_height;
  PlotScript script(title, page_width, bottom + below);
  const auto end = std::next(objects.begin(), static_cast<std::ptrdiff_t>(shown));
  std::size_t with_interval = 0, drawn = 0;
  for (auto object = objects.begin(); object != end; ++object) {
    for (const Figure* measured : {&object->second.seen, &object->second.held_out}) {
      with_interval += measured->has_interval() ? 1U : 0U;
      drawn += std::isfinite(measured->value) ? 1U : 0U;
    }
  }
  script.text(left_out(objects.size(), shown) + "Blue circles: trained with the object; orange squares: without it." +
                  whiskers_in_words(with_interval, drawn),
              20, 52, "left font ',12'", faint_ink);
  script.begin_panel({.left = left, .top = top, .right = page_width - right, .bottom = bottom});
  AccuracyAxis axis;
  std::vector<double> seen, held_out, joined;
  std::vector<std::string> names;
  for (auto object = objects.begin(); object != end; ++object) {
    const auto& [name, of] = *object;
    names.push_back(name);
    axis.include(of.seen);
    axis.include(of.held_out);
    const auto y = static_cast<double>(shown - names.size());
    seen.insert(seen.end(), {percent(of.seen.value), y + 0.14});
    add_interval(seen, of.seen);
    held_out.insert(held_out.end(), {percent(of.held_out.value), y - 0.14});
    add_interval(held_out, of.held_out);
    joined.insert(joined.end(), {percent(of.seen.value), y + 0.14, percent(of.held_out.value - of.seen.value), -0.28});
  }
  script.add("set xrange [{:.9g}:{:.9g}]\nset yrange [-0.6:{:.9g}]", axis.begin(), axis.end(), static_cast<double>(shown) - 0.4);
  script.add("set ytics ({}) scale 0", row_names(names));
  script.add("set xlabel 'accuracy [%]' textcolor rgb '{}'", ink);
  script.add(
      "plot {} using 1:2:3:4 with vectors nohead lc rgb '{}' lw 1.5 notitle, "
      "{} using 1:2:3:4 with xerrorbars lc rgb '{}' lw 1.8 pt 7 ps 1.3 notitle, "
      "{} using 1:2:3:4 with xerrorbars lc rgb '{}' lw 1.8 pt 5 ps 1.3 notitle",
      script.table(4, std::move(joined)), figure_colours::others, script.table(4, std::move(seen)), figure_colours::press,
      script.table(4, std::move(held_out)), figure_colours::slip);
  return std::move(script).plot();
}

Plot confusion_plot(const std::string& title, const Confusion& confusion) {
  constexpr int width = 760, height = 470, left = 130, right = 60, top = 100, below = 40;
  PlotScript script(title, width, height);
  script.text("said", (left + width - right) / 2.0, 60, "center font ',13'");
  script.text("true", 24, (top + height - below) / 2.0, "center rotate by 90 font ',13'");
  script.begin_panel({.left = left, .top = top, .right = width - right, .bottom = height - below});
  script.add("set xrange [0:3]\nset yrange [0:3]\nunset border\nunset grid\nunset xtics\nunset ytics");
  const double field_width = (width - left - right) / 3.0, field_height = (height - top - below) / 3.0;
  for (std::size_t i = 0; i < touch_count; ++i) {
    const auto at = static_cast<double>(i) + 0.5;
    script.text(name_of(all_touches[i]), left + at * field_width, top - 16, "center font ',12'");
    script.text(name_of(all_touches[i]), left - 14, top + at * field_height, "right font ',12'");
    std::uint64_t row = 0;
    for (const std::uint64_t count : confusion.counts[i]) row += count;
    for (std::size_t k = 0; k < touch_count; ++k) {
      const double share = row == 0 ? 0 : static_cast<double>(confusion.counts[i][k]) / static_cast<double>(row);
      // From white to a deep blue.
      const auto mixed = [share](int full) { return static_cast<int>(std::lround(245 + (full - 245) * share)); };
      script.add(
          "set object rectangle from {0}.015, {1}.02 to {0}.985, {1}.98 fillcolor rgb '#{2:02X}{3:02X}{4:02X}' "
          "fillstyle solid noborder",
          k, 2 - i, mixed(0), mixed(58), mixed(130));
      const std::string_view colour = share > 0.5 ? "#FFFFFF" : ink;
      const double x = left + (static_cast<double>(k) + 0.5) * field_width, y = top + at * field_height;
      script.text(row == 0 ? "no sample" : fmt::format("{:.1f} %", 100 * share), x, y - 11, "center font ',16'", colour);
      script.text(fmt::format("{}", confusion.counts[i][k]), x, y + 16, "center font ',12'", colour);
    }
  }
  script.add("plot {} notitle", script.table(2, {}));
  return std::move(script).plot();
}

Plot operating_curve_plot(const std::string& title, const std::vector<OperatingPoint>& points,
                          const std::optional<OperatingPoint>& own) {
  constexpr int left = 90, right = 40, top = 84, gap = 34, delay_height = 290, missed_height = 150, below = 62;
  const int delay_bottom = top + delay_height, missed_top = delay_bottom + gap, bottom = missed_top + missed_height;
  PlotScript script(title, page_width, bottom + below);
  script.text(fmt::format("Blue circles: press; orange squares: slip{}. Numbers: the probability from which on it is said.",
                          own ? "; diamonds: no threshold" : ""),
              20, 52, "left font ',12'", faint_ink);
  std::vector<OperatingPoint> all = points;
  if (own) all.push_back(*own);
  // False alarms span decades: their logarithm, with none at all at a place of its own on the left.
  double most_alarms = 0, least_alarms = 1e9, longest = 0, most_missed = 0;
  for (const OperatingPoint& point : all) {
    if (const double alarms = point.false_alarms_per_min.value; std::isfinite(alarms) && alarms > 0) {
      most_alarms = std::max(most_alarms, alarms);
      least_alarms = std::min(least_alarms, alarms);
    }
    for (const DelaySummary& touch : {point.press, point.slip}) {
      if (std::isfinite(touch.mean_ms.value)) longest = std::max(longest, touch.mean_ms.value);
      if (std::isfinite(touch.missed_share())) most_missed = std::max(most_missed, percent(touch.missed_share()));
    }
  }
  if (most_alarms <= 0) most_alarms = least_alarms = 1;
  if (longest <= 0) longest = 1;
  const int begin = static_cast<int>(std::floor(std::log10(least_alarms)));
  const int end = std::max(begin + 1, static_cast<int>(std::ceil(std::log10(most_alarms))));
  const double none_at = begin - 0.12 * (end - begin), span = end - none_at;
  const auto place_of = [&](const OperatingPoint& point) {
    const double alarms = point.false_alarms_per_min.value;
    return alarms > 0 ? std::log10(alarms) : alarms == 0 ? none_at : alarms;
  };
  std::string tics = fmt::format("'none' {:.9g}", none_at), bare_tics = fmt::format("'' {:.9g}", none_at);
  for (int decade = begin; decade <= end; ++decade) {
    tics += fmt::format(", '{:g}' {}", std::pow(10, decade), decade);
    bare_tics += fmt::format(", '' {}", decade);
  }
  std::vector<double> delays, missed;
  for (const OperatingPoint& point : points) {
    const double x = place_of(point);
    delays.insert(delays.end(), {x, point.press.mean_ms.value, point.slip.mean_ms.value});
    missed.insert(missed.end(), {x, percent(point.press.missed_share()), percent(point.slip.missed_share())});
  }
  const auto begin_panel = [&](int panel_top, int panel_bottom, double most, std::string_view label) {
    script.begin_panel({.left = left, .top = panel_top, .right = page_width - right, .bottom = panel_bottom});
    script.add("set xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]", none_at - 0.03 * span, end + 0.03 * span, -0.03 * most,
               1.18 * most);
    script.add("set ylabel {} textcolor rgb '{}'", plot_text(label), ink);
  };
  const auto draw_lines = [&](std::vector<double> values, std::vector<double> of_own) {
    script.add(
        "plot {0} using 1:2 with linespoints lc rgb '{1}' lw 1.6 pt 7 ps 1.3 notitle, "
        "{0} using 1:3 with linespoints lc rgb '{2}' lw 1.6 dt 2 pt 5 ps 0.7 notitle, "
        "{3} using 1:2 with points lc rgb '{1}' lw 2.2 pt 12 ps 2.6 notitle, "
        "{3} using 1:3 with points lc rgb '{2}' lw 2.2 pt 12 ps 2.6 notitle",
        script.table(3, std::move(values)), figure_colours::press, figure_colours::slip, script.table(3, std::move(of_own)));
  };
  const auto values_of_own = [&](auto of_touch) {
    if (!own) return std::vector<double>();
    return std::vector<double>{place_of(*own), of_touch(own->press), of_touch(own->slip)};
  };
  begin_panel(top, delay_bottom, longest, "mean delay [ms]");
  script.add("set xtics ({})", bare_tics);
  // Thresholds are told beside their points, only where nothing else is.
  constexpr double word_character = 8.5;  // [px]
  const auto across = [&](double x) { return left + (page_width - left - right) * (x - none_at + 0.03 * span) / (1.06 * span); };
  const auto down = [&](double delay_ms) { return delay_bottom - delay_height * (delay_ms + 0.03 * longest) / (1.21 * longest); };
  WordPlaces places({.left = left, .top = top, .right = page_width - right, .bottom = delay_bottom});
  for (const OperatingPoint& point : all) {
    constexpr double half = 7;
    const double x = across(place_of(point));
    for (const DelaySummary& touch : {point.press, point.slip}) {
      const double y = down(touch.mean_ms.value);
      if (std::isfinite(x) && std::isfinite(y)) places.take(x - half, y - half, x + half, y + half);
    }
  }
  // Nor do curves lead through words.
  for (std::size_t i = 1; i < points.size(); ++i) {
    const OperatingPoint &from = points[i - 1], &to = points[i];
    const double x = across(place_of(from)), to_x = across(place_of(to));
    for (const auto& [from_ms, to_ms] : {std::pair(from.press.mean_ms.value, to.press.mean_ms.value),
                                         std::pair(from.slip.mean_ms.value, to.slip.mean_ms.value)}) {
      if (std::isfinite(x) && std::isfinite(to_x) && std::isfinite(from_ms) && std::isfinite(to_ms))
        places.take_line(x, down(from_ms), to_x, down(to_ms));
    }
  }
  for (const Touch touch : {Touch::slip, Touch::press}) {
    for (const double wanted : {0.5, 0.99, 0.9, 0.999, 0.1}) {
      const auto point = std::find_if(points.begin(), points.end(),
                                      [wanted](const OperatingPoint& one) { return std::abs(one.threshold - wanted) < 1e-9; });
      if (point == points.end()) continue;
      const double delay_ms = (touch == Touch::press ? point->press : point->slip).mean_ms.value;
      const std::string words = fmt::format("{:.4g}", wanted);
      const WordPlaces::Place place =
          places.near(across(place_of(*point)), down(delay_ms), word_character * static_cast<double>(words.size()));
      if (!place.is_plain()) continue;
      places.take(place);
      script.text(words, place.x, place.y, "center font ',10'", figure_colours::of(touch));
    }
  }
  draw_lines(std::move(delays), values_of_own([](const DelaySummary& touch) { return touch.mean_ms.value; }));
  begin_panel(missed_top, bottom, std::max(5.0, most_missed), "missed or early [%]");
  script.add("set xtics ({})\nset xlabel 'false alarms per minute' textcolor rgb '{}'", tics, ink);
  draw_lines(std::move(missed), values_of_own([](const DelaySummary& touch) { return percent(touch.missed_share()); }));
  return std::move(script).plot();
}

Plot reliability_plot(const std::string& title, const std::vector<ReliabilityBin>& bins) {
  constexpr int width = 760, left = 90, right = 40, top = 84, gap = 30, upper_height = 380, lower_height = 110, below = 62;
  const int upper_bottom = top + upper_height, lower_top = upper_bottom + gap, bottom = lower_top + lower_height;
  PlotScript script(title, width, bottom + below);
  script.text(fmt::format("Dashed: as often right as it is sure. Hollow: fewer than {} samples.", few_samples), 20, 52,
              "left font ',12'", faint_ink);
  std::vector<double> accuracies, of_few, boxes;
  std::uint64_t most = 1;
  double least = 100;
  for (const ReliabilityBin& bin : bins) {
    if (bin.samples == 0) continue;
    std::vector<double>& points = bin.samples < few_samples ? of_few : accuracies;
    points.insert(points.end(), {percent(bin.confidence), percent(bin.accuracy.value)});
    add_interval(points, bin.accuracy);
    const auto samples = static_cast<double>(bin.samples);
    boxes.insert(boxes.end(), {percent((bin.from + bin.to) / 2), samples, percent(bin.from), percent(bin.to), 0.8, samples});
    most = std::max(most, bin.samples);
    least = std::min(least, percent(bin.from));
  }
  const double begin = std::min(30.0, 10 * std::floor(least / 10));
  script.begin_panel({.left = left, .top = top, .right = width - right, .bottom = upper_bottom});
  script.add("set xrange [{0:.9g}:101]\nset yrange [0:102]\nset format x ''\nset ylabel 'said right [%]' textcolor rgb '{1}'",
             begin, ink);
  script.add("set arrow from first {0:.9g}, first {0:.9g} to first 100, first 100 nohead dt 2 lc rgb '{1}' lw 1.2", begin,
             faint_ink);
  const std::string of_many_table = script.table(4, std::move(accuracies)), of_few_table = script.table(4, std::move(of_few));
  script.add(
      "plot {0} using 1:2:3:4 with yerrorbars lc rgb '{1}' lw 1.6 pt 7 ps 1.1 notitle, "
      "{0} using 1:2 with lines lc rgb '{1}' lw 1.6 notitle, "
      "{2} using 1:2:3:4 with yerrorbars lc rgb '{1}' lw 1 dt 1 pt 6 ps 1.1 notitle",
      of_many_table, figure_colours::network, of_few_table);
  script.begin_panel({.left = left, .top = lower_top, .right = width - right, .bottom = bottom});
  script.add("set xrange [{:.9g}:101]\nset logscale y\nset yrange [0.8:{:.9g}]\nset format y '%.0f'", begin,
             2.0 * static_cast<double>(most));
  std::string tics;
  for (double ten = 1; ten <= static_cast<double>(most); ten *= most >= 1'000'000 ? 100 : 10)
    tics += fmt::format("{}{:.0f}", tics.empty() ? "" : ", ", ten);
  script.add("set ytics ({})\nset ylabel 'samples' textcolor rgb '{}'\nset xlabel 'largest probability [%]' textcolor rgb '{}'",
             tics, ink, ink);
  script.add("plot {} using 1:2:3:4:5:6 with boxxyerror fs solid 0.6 noborder lc rgb '{}' notitle",
             script.table(6, std::move(boxes)), figure_colours::faint_ink);
  return std::move(script).plot();
}

Plot training_plot(const std::string& title, const std::vector<TrainingCurve>& curves) {
  constexpr int left = 96, right = 20, top = 84, gap = 84, panel_height = 320, below = 76, key_row = 24;
  constexpr std::size_t most_named = 8;
  const std::size_t named = std::min(curves.size(), most_named);
  const int bottom = top + panel_height, key_rows = static_cast<int>((named + 1) / 2);
  const int height = bottom + below + key_rows * key_row + 10;
  PlotScript script(title, page_width, height);
  bool has_later = false;
  double most_epochs = 1, greatest_loss = 0, least_loss = 1e9;
  AccuracyAxis axis;
  std::vector<std::string> tables;
  for (const TrainingCurve& curve : curves) {
    std::vector<double> values;
    for (const TrainingCurve::Epoch& epoch : curve.epochs) {
      values.insert(values.end(), {epoch.epoch, epoch.loss, percent(epoch.accuracy), percent(epoch.later_accuracy)});
      most_epochs = std::max(most_epochs, epoch.epoch);
      if (std::isfinite(epoch.loss) && epoch.loss > 0) {
        greatest_loss = std::max(greatest_loss, epoch.loss);
        least_loss = std::min(least_loss, epoch.loss);
      }
      axis.include({.value = epoch.accuracy});
      axis.include({.value = epoch.later_accuracy});
      has_later = has_later || std::isfinite(epoch.later_accuracy);
    }
    tables.push_back(script.table(4, std::move(values)));
  }
  if (greatest_loss <= 0) greatest_loss = least_loss = 1;
  script.text(std::string("One line for each training") +
                  (curves.size() > named ? fmt::format("; grey: {} more", curves.size() - named) : "") +
                  (has_later ? "; hollow marks without a line: accuracy on the part kept for validation." : "."),
              20, 52, "left font ',12'", faint_ink);
  const int width = (page_width - left - right - gap) / 2;
  // Grey ones first, so that those with a name lie over them.
  const auto lines_of = [&](int column, bool later) {
    std::string lines;
    for (std::size_t i = curves.size(); i-- > 0;) {
      const LineStyle style = line_style(i);
      if (i >= named) {
        lines += fmt::format("{} using 1:{} with lines lc rgb '{}' lw 1 notitle, ", tables[i], column, figure_colours::others);
        continue;
      }
      lines += fmt::format("{} using 1:{} with linespoints lc rgb '{}' dt {} pt {} ps 0.8 lw 1.6 notitle, ", tables[i], column,
                           style.colour, style.dashes, style.mark);
      if (later)
        lines += fmt::format("{} using 1:4 with points lc rgb '{}' pt {} ps 1.1 lw 1.6 notitle, ", tables[i], style.colour, 6);
    }
    lines += fmt::format("{} using 1:2 notitle", script.table(4, {}));
    return lines;
  };
  script.begin_panel({.left = left, .top = top, .right = left + width, .bottom = bottom});
  script.add("set logscale y\nset xrange [0.5:{:.9g}]\nset yrange [{:.9g}:{:.9g}]\nset format y '%.3g'\nset ytics ({})",
             most_epochs + 0.5, least_loss / 1.3, greatest_loss * 1.3, decade_tics(least_loss / 1.3, greatest_loss * 1.3));
  script.add("set xlabel 'epoch' textcolor rgb '{0}'\nset ylabel 'loss' textcolor rgb '{0}'", ink);
  script.add("plot {}", lines_of(2, false));
  script.begin_panel({.left = left + width + gap, .top = top, .right = page_width - right, .bottom = bottom});
  script.add("set xrange [0.5:{:.9g}]\nset yrange [{:.9g}:{:.9g}]", most_epochs + 0.5, axis.begin(), axis.end());
  script.add("set xlabel 'epoch' textcolor rgb '{0}'\nset ylabel 'accuracy in training [%]' textcolor rgb '{0}'", ink);
  for (std::size_t i = 0; i < named; ++i) {
    // The key, under the panels, in two columns.
    const LineStyle style = line_style(i);
    const double x = i % 2 == 0 ? left : page_width / 2.0 + 20, y = bottom + below + static_cast<double>(i / 2) * key_row + 6;
    const double screen_y = 1 - y / height;
    script.text(shortened(curves[i].name, 50), x + 56, y, "left font ',12'");
    script.add("set arrow from screen {:.6f}, screen {:.6f} to screen {:.6f}, screen {:.6f} nohead lc rgb '{}' dt {} lw 1.8",
               x / page_width, screen_y, (x + 44) / page_width, screen_y, style.colour, style.dashes);
    script.add("set label '' at screen {:.6f}, screen {:.6f} point pt {} ps 1 lc rgb '{}'", (x + 22) / page_width, screen_y,
               style.mark, style.colour);
  }
  script.add("plot {}", lines_of(3, has_later));
  return std::move(script).plot();
}

Plot over_time_plot(const std::string& title, const AccuracyOverTime& press, const AccuracyOverTime& slip) {
  constexpr int left = 80, right = 30, top = 106, gap = 64, panel_height = 320, below = 62;
  const int bottom = top + panel_height, width = (page_width - left - right - gap) / 2;
  PlotScript script(title, page_width, bottom + below);
  std::size_t with_interval = 0, drawn = 0;
  for (const AccuracyOverTime* touch : {&press, &slip}) {
    for (const std::vector<OverTimeBin>* bins : {&touch->since_onset, &touch->before_end}) {
      for (const OverTimeBin& bin : *bins) {
        drawn += std::isfinite(bin.accuracy.value) ? 1U : 0U;
        with_interval += bin.accuracy.has_interval() ? 1U : 0U;
      }
    }
  }
  script.text("Blue circles: press; orange squares: slip. Share of ticks said right." + whiskers_in_words(with_interval, drawn),
              20, 52, "left font ',12'", faint_ink);
  AccuracyAxis axis;
  for (const AccuracyOverTime* touch : {&press, &slip}) {
    for (const std::vector<OverTimeBin>* bins : {&touch->since_onset, &touch->before_end}) {
      for (const OverTimeBin& bin : *bins) axis.include(bin.accuracy);
    }
  }
  const auto table_of = [&](const std::vector<OverTimeBin>& bins) {
    std::vector<double> values;
    for (const OverTimeBin& bin : bins) {
      values.insert(values.end(), {in_ms(bin.from + bin.to) / 2, percent(bin.accuracy.value)});
      add_interval(values, bin.accuracy);
    }
    return script.table(4, std::move(values));
  };
  for (const bool from_onset : {true, false}) {
    const int begin = from_onset ? left : left + width + gap;
    double longest = 100;
    for (const AccuracyOverTime* touch : {&press, &slip}) {
      for (const OverTimeBin& bin : from_onset ? touch->since_onset : touch->before_end)
        longest = std::max(longest, in_ms(bin.to));
    }
    script.begin_panel({.left = begin, .top = top, .right = begin + width, .bottom = bottom});
    script.text(from_onset ? "since the onset" : "before the end", begin + width / 2.0, top - 16, "center font ',13'");
    script.add("set yrange [{:.9g}:{:.9g}]", axis.begin(), axis.end());
    if (from_onset)
      script.add("set xrange [0:{:.9g}]\nset ylabel 'said right [%]' textcolor rgb '{}'", longest, ink);
    else
      script.add("set xrange [{:.9g}:0]\nset format y ''", longest);
    script.add("set xlabel '{}' textcolor rgb '{}'", from_onset ? "time since the onset [ms]" : "time before the end [ms]", ink);
    const std::string of_press = table_of(from_onset ? press.since_onset : press.before_end);
    const std::string of_slip = table_of(from_onset ? slip.since_onset : slip.before_end);
    script.add(
        "plot {0} using 1:2:3:4 with yerrorbars lc rgb '{2}' lw 1.2 pt 7 ps 0.7 notitle, "
        "{0} using 1:2 with lines lc rgb '{2}' lw 1.6 notitle, "
        "{1} using 1:2:3:4 with yerrorbars lc rgb '{3}' lw 1.2 pt 5 ps 0.7 notitle, "
        "{1} using 1:2 with lines lc rgb '{3}' lw 1.6 dt 2 notitle",
        of_press, of_slip, figure_colours::press, figure_colours::slip);
  }
  return std::move(script).plot();
}

}  // namespace tactile
