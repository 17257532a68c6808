#include "tactile/report/object_plots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <span>

#include "tactile/pictures/plot_script.hpp"
#include "tactile/report/figure_parts.hpp"

namespace tactile::report {
namespace {

using pictures::figure_colours::ink;

std::vector<double> values_of(const HistoryCurve& curve) {
  std::vector<double> values;
  for (const HistoryCurve::Point& point : curve.points) {
    values.insert(values.end(), {point.history_ms, percent(point.accuracy.value)});
    add_interval(values, point.accuracy);
  }
  return values;
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

pictures::Plot accuracy_by_history_plot(const std::string& title, const std::vector<HistoryCurve>& curves) {
  constexpr int columns = 3, left = 60, right = 16, gap = 18, panel_height = 130, row_height = 188, below = 66;
  constexpr int width = (page_width - left - right - (columns - 1) * gap) / columns;
  const auto shown = std::span(curves).first(std::min(curves.size(), most_panels));
  const int rows = std::max(1, (static_cast<int>(shown.size()) + columns - 1) / columns);
  AccuracyAxis axis;
  Whiskers whiskers;
  std::set<double> histories;
  for (const HistoryCurve& curve : curves) {
    for (const HistoryCurve::Point& point : curve.points) {
      axis.include(point.accuracy);
      whiskers.include(point.accuracy);
      histories.insert(point.history_ms);
    }
  }
  const double longest = histories.empty() ? 50 : *histories.rbegin();
  const std::string tics = histories.size() <= 8 ? fmt::format("{:g}", fmt::join(histories, ", ")) : "";
  const pictures::LineStyle own_line{.colour = pictures::figure_colours::network, .width = 2.2, .mark = 7, .size = 0.7};
  const pictures::LineStyle best_mark{.colour = pictures::figure_colours::best, .width = 0, .mark = 13, .size = 1.5};
  pictures::PlotHead head(title, page_width);
  head.note(first_of(curves.size(), shown.size()));
  head.key("this object", own_line);
  head.key("other objects", {.colour = pictures::figure_colours::others});
  head.key("best history", best_mark);
  whiskers.explain(head);
  const int top = head.bottom() + 54;
  pictures::PlotScript script(head, top + (rows - 1) * row_height + panel_height + below);
  script.text("accuracy [%]", 20, top - 34, "left font ',12'");
  script.text("history t_h [ms]", page_width / 2.0, top + (rows - 1) * row_height + panel_height + 48, "center font ',12'");
  std::vector<pictures::PlotSeries> grey;
  for (const HistoryCurve& curve : shown)
    grey.push_back({script.table(4, values_of(curve)), "1:2", "lines", {.colour = pictures::figure_colours::others}});
  for (std::size_t i = 0; i < std::max<std::size_t>(shown.size(), 1); ++i) {
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    const int panel_left = left + column * (width + gap), panel_top = top + row * row_height;
    script.begin_panel({.left = panel_left, .top = panel_top, .right = panel_left + width, .bottom = panel_top + panel_height});
    script.axes({.begin = -0.03 * longest, .end = 1.06 * longest, .tics = tics},
                {.begin = axis.begin(), .end = axis.end(), .has_labels = column == 0});
    std::vector<pictures::PlotSeries> series = grey;
    if (shown.empty()) {
      series.push_back({script.table(2, {}), "1:2", "lines", {.colour = pictures::figure_colours::others}});
    } else {
      // The panel's own curve lies over the others.
      const std::string own = grey[i].table;
      series.erase(series.begin() + static_cast<std::ptrdiff_t>(i));
      pictures::LineStyle bars = own_line, line = own_line;
      bars.width = 1.4;
      line.mark.reset();
      series.push_back({own, "1:2:3:4", "yerrorbars", bars});
      series.push_back({own, "1:2", "lines", line});
      script.text(pictures::shortened(shown[i].name, 19), panel_left + width / 2.0, panel_top - 12, "center font ',12'");
      if (const auto best = best_of(shown[i]); best != shown[i].points.end())
        series.push_back({script.table(2, {best->history_ms, percent(best->accuracy.value)}), "1:2", "points", best_mark});
    }
    script.plot(series);
  }
  return std::move(script).finished();
}

namespace {

constexpr int delay_left = 188, delay_right = 20, delay_row = 28, delay_above = 34, delay_below = 60;

bool has_whiskers(const std::map<std::string, results::DelaySummary>& bars) {
  return std::any_of(bars.begin(), bars.end(), [](const auto& bar) { return std::isfinite(bar.second.sem_ms); });
}

/// The mean, and what the mean leaves out.
std::string words_of(const results::DelaySummary& delay) {
  if (delay.intervals == 0) return "no interval";
  std::string words = std::isfinite(delay.mean_ms.value) ? fmt::format("{:.1f}", delay.mean_ms.value) : "none";
  if (delay.misses > 0) words += fmt::format(", {} missed", delay.misses);
  if (delay.early > 0) words += fmt::format(", {} early", delay.early);
  return words;
}

void add_delay_panel(pictures::PlotScript& script, Touch touch, std::span<const std::string> names,
                     const std::map<std::string, results::DelaySummary>& bars, double limit_ms, int top) {
  constexpr double note_share = 0.46;  // of the panel's width, for words beside the bars
  const int bottom = top + static_cast<int>(std::max<std::size_t>(names.size(), 1)) * delay_row;
  script.begin_panel({.left = delay_left, .top = top, .right = page_width - delay_right, .bottom = bottom});
  script.text(name_of(touch), (delay_left + page_width - delay_right) / 2.0, top - 16, "center font ',13'",
              pictures::figure_colours::of(touch));
  double longest = limit_ms;
  std::vector<double> boxes, whiskers;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = bars.find(names[i]);
    const results::DelaySummary bar = found == bars.end() ? results::DelaySummary{} : found->second;
    const auto y = static_cast<double>(names.size() - 1 - i);
    script.add("set label {} at graph {:.4f}, first {} left font ',10' textcolor rgb '{}' front",
               pictures::plot_text(words_of(bar)), 1 - note_share + 0.03, y, pictures::figure_colours::ink);
    const double mean = bar.mean_ms.value, sem = bar.sem_ms;
    if (!std::isfinite(mean)) continue;
    boxes.insert(boxes.end(), {mean / 2, y, std::min(0.0, mean), std::max(0.0, mean), y - 0.32, y + 0.32});
    if (std::isfinite(sem)) whiskers.insert(whiskers.end(), {mean, y, mean - sem, mean + sem});
    longest = std::max(longest, mean + (std::isfinite(sem) ? sem : 0));
  }
  const double bars_end = 1.04 * longest;
  script.axes({.end = bars_end / (1 - note_share), .label = "detection delay [ms]"},
              {.begin = -0.6,
               .end = static_cast<double>(names.size()) - 0.4,
               .tics = row_names({names.begin(), names.end()}),
               .tic_style = "scale 0"});
  script.add("unset grid\nset grid x lt 1 lc rgb '{}' lw 0.6", pictures::figure_colours::grid);
  script.add("set arrow from first {0:.9g}, graph 0 to first {0:.9g}, graph 1 nohead dt 2 lc rgb '{1}' lw 1.2 front", limit_ms,
             pictures::figure_colours::ink);
  // Tics end where the words begin.
  const double step = std::pow(10, std::floor(std::log10(bars_end / 2)));
  script.add("set xtics 0, {:.9g}, {:.9g}", bars_end / step > 10 ? 5 * step : bars_end / step > 5 ? 2 * step : step, bars_end);
  script.plot({{script.table(6, std::move(boxes)),
                "1:2:3:4:5:6",
                "boxxyerror",
                {.colour = pictures::figure_colours::of(touch), .fill = 0.75}},
               {script.table(4, std::move(whiskers)),
                "1:2:3:4",
                "xerrorbars",
                {.colour = pictures::figure_colours::ink, .width = 1.6, .mark = 0}}});
}

}  // namespace

pictures::Plot delay_plot(const std::string& title, const std::vector<std::string>& objects,
                          const std::map<std::string, results::DelaySummary>& press,
                          const std::map<std::string, results::DelaySummary>& slip, double limit_ms) {
  const auto names = std::span(objects).first(std::min(objects.size(), most_panels));
  const int rows = static_cast<int>(std::max<std::size_t>(names.size(), 1));
  pictures::PlotHead head(title, page_width);
  head.note(first_of(objects.size(), names.size()));
  head.key("mean of detected presses", {.colour = pictures::figure_colours::press, .fill = 0.75});
  head.key("of detected slips", {.colour = pictures::figure_colours::slip, .fill = 0.75});
  if (has_whiskers(press) || has_whiskers(slip)) head.key("standard error", {.colour = ink, .width = 1.6});
  head.key(fmt::format("the paper's limit, {:g} ms", limit_ms), {.colour = ink, .width = 1.2, .dashes = 2});
  const int panel_height = delay_above + rows * delay_row + delay_below;
  pictures::PlotScript script(head, head.bottom() + 2 * panel_height);
  add_delay_panel(script, Touch::press, names, press, limit_ms, head.bottom() + delay_above);
  add_delay_panel(script, Touch::slip, names, slip, limit_ms, head.bottom() + panel_height + delay_above);
  return std::move(script).finished();
}

pictures::Plot unseen_plot(const std::string& title, const std::map<std::string, results::SeenAndHeldOut>& objects) {
  constexpr int left = 188, right = 20, row_height = 44, below = 60;
  constexpr double apart = 0.14;  // from the row's middle
  const std::size_t shown = std::min(objects.size(), most_panels);
  AccuracyAxis axis;
  Whiskers whiskers;
  std::vector<double> seen, held_out, joined;
  std::vector<std::string> names;
  for (auto object = objects.begin(); names.size() < shown; ++object) {
    const auto& [name, of] = *object;
    names.push_back(name);
    const auto y = static_cast<double>(shown - names.size());
    const auto add = [&](std::vector<double>& values, const results::Figure& accuracy, double at) {
      axis.include(accuracy);
      whiskers.include(accuracy);
      values.insert(values.end(), {percent(accuracy.value), at});
      add_interval(values, accuracy);
    };
    add(seen, of.seen, y + apart);
    add(held_out, of.held_out, y - apart);
    joined.insert(joined.end(), {percent(of.seen.value), y + apart, percent(of.held_out.value - of.seen.value), -2 * apart});
  }
  const pictures::LineStyle with{.colour = pictures::figure_colours::press, .width = 1.8, .mark = 7, .size = 1.3};
  const pictures::LineStyle without{.colour = pictures::figure_colours::slip, .width = 1.8, .mark = 5, .size = 1.3};
  pictures::PlotHead head(title, page_width);
  head.note(first_of(objects.size(), shown));
  head.key("trained with the object", mark_of(with));
  head.key("without it", mark_of(without));
  whiskers.explain(head);
  const int top = head.bottom() + 14, bottom = top + static_cast<int>(std::max<std::size_t>(shown, 1)) * row_height;
  pictures::PlotScript script(head, bottom + below);
  script.begin_panel({.left = left, .top = top, .right = page_width - right, .bottom = bottom});
  script.axes({.begin = axis.begin(), .end = axis.end(), .label = "accuracy [%]"},
              {.begin = -0.6, .end = static_cast<double>(shown) - 0.4, .tics = row_names(names), .tic_style = "scale 0"});
  script.plot({{script.table(4, std::move(joined)),
                "1:2:3:4",
                "vectors nohead",
                {.colour = pictures::figure_colours::others, .width = 1.5}},
               {script.table(4, std::move(seen)), "1:2:3:4", "xerrorbars", with},
               {script.table(4, std::move(held_out)), "1:2:3:4", "xerrorbars", without}});
  return std::move(script).finished();
}

}  // namespace tactile::report
