#include "tactile/report/figure_parts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tactile/pictures/plot_script.hpp"

namespace tactile::report {

void AccuracyAxis::include(const results::Figure& accuracy) {
  for (const double value : {accuracy.value, accuracy.low.value_or(NAN)}) {
    if (std::isfinite(value)) least_ = std::min(least_, percent(value));
  }
}

double AccuracyAxis::begin() const { return std::clamp(10 * std::floor((least_ - 1) / 10), 0.0, 90.0); }

void Whiskers::include(const results::Figure& measured) {
  values_ += std::isfinite(measured.value) ? 1U : 0U;
  intervals_ += measured.has_interval() ? 1U : 0U;
}

void Whiskers::explain(pictures::PlotHead& head) const {
  if (intervals_ == 0)
    head.note("No intervals: they need 3 runs or objects, and 1 training or 3.");
  else
    head.key(intervals_ < values_ ? "95 % interval, where there is one" : "95 % interval",
             {.colour = pictures::figure_colours::ink});
}

pictures::LineStyle mark_of(pictures::LineStyle style) {
  style.width = 0;
  return style;
}

void add_interval(std::vector<double>& values, const results::Figure& measured) {
  values.push_back(percent(measured.has_interval() ? *measured.low : measured.value));
  values.push_back(percent(measured.has_interval() ? *measured.high : measured.value));
}

std::string first_of(std::size_t there, std::size_t shown) {
  return there > shown ? fmt::format("The first {} of {} are shown. ", shown, there) : std::string();
}

std::string row_names(const std::vector<std::string>& names) {
  std::string tics;
  for (std::size_t i = 0; i < names.size(); ++i)
    tics +=
        fmt::format("{}{} {}", i == 0 ? "" : ", ", pictures::plot_text(pictures::shortened(names[i], 22)), names.size() - 1 - i);
  return tics.empty() ? "'' 0" : tics;
}

std::vector<pictures::PlotSeries> border_marks(pictures::PlotScript& script, const std::vector<double>& rows,
                                               const AxisRange& range, const pictures::LineStyle& style) {
  constexpr int columns = 4, up = 9, down = 11;  // filled triangles of gnuplot
  constexpr double half_mark = 4;                // [px]
  const double inside = half_mark * (range.end - range.begin) / range.pixels;
  std::vector<double> above, below;
  for (std::size_t i = 0; i + columns <= rows.size(); i += columns) {
    if (rows[i + 3] > range.end) above.insert(above.end(), {rows[i], range.end - inside});
    if (rows[i + 2] < range.begin) below.insert(below.end(), {rows[i], range.begin + inside});
  }
  std::vector<pictures::PlotSeries> series;
  pictures::LineStyle mark{.colour = style.colour, .width = 1, .dashes = 1, .mark = up, .size = 0.9};
  if (!above.empty()) series.push_back({script.table(2, above), "1:2", "points", mark});
  mark.mark = down;
  if (!below.empty()) series.push_back({script.table(2, below), "1:2", "points", mark});
  return series;
}

}  // namespace tactile::report
