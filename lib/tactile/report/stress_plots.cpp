#include "tactile/report/stress_plots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tactile/pictures/plot_script.hpp"
#include "tactile/report/axis_tics.hpp"
#include "tactile/report/figure_parts.hpp"

namespace tactile::report {
namespace {

namespace colours = pictures::figure_colours;

constexpr int columns = 2, left = 64, right = 18, gap = 30, panel_height = 130, row_height = 212, below = 66;
constexpr int width = (page_width - left - right - (columns - 1) * gap) / columns;

/// A line of a panel: what it shows of a point, and how it is drawn.
struct Line {
  std::string words;
  std::size_t model = 0;
  pictures::LineStyle style{};
};

const std::vector<results::StressCurve>& curves_of(const results::StressedModel& model, bool of_quiet) {
  return of_quiet ? model.quiet : model.curves;
}

std::vector<Line> lines_of(const results::Stress& stress) {
  std::vector<Line> lines;
  for (std::size_t i = 0; i < stress.models.size(); ++i) {
    const std::string name = pictures::shortened(stress.models[i].name, 44);
    lines.push_back({name, i, pictures::line_style(i)});
  }
  return lines;
}

/// In the unit of the axis.
results::Figure figure_of(const results::StressPoint& point, StressMeasure measure) {
  switch (measure) {
    case StressMeasure::accuracy:
      return results::scaled(point.accuracy, 100);
    case StressMeasure::within_50_ms:
      return results::scaled(point.whole.within_50_ms, 100);
    case StressMeasure::false_alarms:
      return point.whole.alarms_per_min;
  }
  return {};
}

double position_of(double value, StressMeasure measure) {
  return measure == StressMeasure::false_alarms ? drawn_from_zero(value) : value;
}

/// Rows of place, value, low, high. @param aside  added to the place, so that bars of several lines do not hide each other
std::vector<double> rows_of(const results::StressCurve& curve, StressMeasure measure, double aside) {
  std::vector<double> rows;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const results::Figure figure = figure_of(curve.points[i], measure);
    const double value = position_of(figure.value, measure);
    rows.insert(rows.end(), {static_cast<double>(i) + aside, value, figure.low ? position_of(*figure.low, measure) : value,
                             figure.high ? position_of(*figure.high, measure) : value});
  }
  return rows;
}

/// The upper end of the axis, from the values; intervals that reach further are cut.
double end_of(const results::Stress& stress, StressMeasure measure, bool of_quiet) {
  if (measure != StressMeasure::false_alarms) return 103;
  double most = 1;
  for (const results::StressedModel& model : stress.models) {
    for (const results::StressCurve& curve : curves_of(model, of_quiet)) {
      for (const results::StressPoint& point : curve.points) {
        const double value = point.whole.alarms_per_min.value;
        if (std::isfinite(value)) most = std::max(most, value);
      }
    }
  }
  return position_of(1.5 * most, measure);
}

std::string severity_tics(const results::StressCurve& curve) {
  std::string tics;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const double severity = curve.points[i].severity;
    const std::string label = severity >= 1000 ? fmt::format("{:g}k", severity / 1000) : fmt::format("{:g}", severity);
    tics += fmt::format("{}'{}' {}", i == 0 ? "" : ", ", label, i);
  }
  return tics.empty() ? "'' 0" : tics;
}

std::string_view title_of(StressMeasure measure) {
  switch (measure) {
    case StressMeasure::accuracy:
      return "Accuracy against severity";
    case StressMeasure::within_50_ms:
      return "Touches detected within 50 ms, against severity";
    case StressMeasure::false_alarms:
      return "False alarms against severity";
  }
  return "";
}

std::string_view unit_of(StressMeasure measure) {
  switch (measure) {
    case StressMeasure::accuracy:
      return "accuracy [%]";
    case StressMeasure::within_50_ms:
      return "detected within 50 ms [%]";
    case StressMeasure::false_alarms:
      return "false alarms per minute";
  }
  return "";
}

Whiskers whiskers_of(const results::Stress& stress, const std::vector<Line>& lines, StressMeasure measure, bool of_quiet) {
  Whiskers whiskers;
  for (const Line& line : lines) {
    for (const results::StressCurve& curve : curves_of(stress.models[line.model], of_quiet)) {
      for (const results::StressPoint& point : curve.points) whiskers.include(figure_of(point, measure));
    }
  }
  return whiskers;
}

}  // namespace

pictures::Plot stress_plot(const results::Stress& stress, StressMeasure measure, bool of_quiet) {
  const std::vector<Line> lines = lines_of(stress);
  static const std::vector<results::StressCurve> none;
  const auto& curves = stress.models.empty() ? none : curves_of(stress.models.front(), of_quiet);
  const std::size_t shown = std::min(curves.size(), most_panels);
  const int rows = std::max(1, (static_cast<int>(shown) + columns - 1) / columns);
  std::string title(title_of(measure));
  if (of_quiet) title += " (recordings without a touch)";
  if (stress.simulated && !of_quiet) title += " (simulated runs)";
  pictures::PlotHead head(title, page_width);
  head.note(first_of(curves.size(), shown) + "Severity 0 is the unchanged recording.");
  for (const Line& line : lines) head.key(line.words, line.style);
  const Whiskers whiskers = whiskers_of(stress, lines, measure, of_quiet);
  whiskers.explain(head);
  if (whiskers.any()) head.key("it leaves the panel", {.colour = colours::ink, .width = 0, .mark = 9, .size = 0.9});
  const int top = head.bottom() + 64;
  pictures::PlotScript script(head, top + (rows - 1) * row_height + panel_height + below);
  script.text(unit_of(measure), 20, top - 42, "left font ',12'");
  const AxisRange range{measure == StressMeasure::false_alarms ? -0.03 : -3, end_of(stress, measure, of_quiet), panel_height};
  const auto alarm_tics = [&](bool has_labels) {
    return measure == StressMeasure::false_alarms ? decade_tics(range, true, true).text(has_labels) : std::string();
  };
  for (std::size_t i = 0; i < std::max<std::size_t>(shown, 1); ++i) {
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    const int panel_left = left + column * (width + gap), panel_top = top + row * row_height;
    script.begin_panel({.left = panel_left, .top = panel_top, .right = panel_left + width, .bottom = panel_top + panel_height});
    const results::StressCurve empty;
    const results::StressCurve& curve = shown == 0 ? empty : curves[i];
    const double last = static_cast<double>(std::max<std::size_t>(curve.points.size(), 2)) - 1;
    script.axes({.begin = -0.08 * last, .end = 1.08 * last, .tics = severity_tics(curve)},
                {.begin = range.begin, .end = range.end, .tics = alarm_tics(column == 0), .has_labels = column == 0});
    std::vector<pictures::PlotSeries> series;
    for (std::size_t place = 0; place < lines.size(); ++place) {
      const Line& line = lines[place];
      const double aside = 0.025 * last * (static_cast<double>(place) - static_cast<double>(lines.size() - 1) / 2);
      const auto& own = curves_of(stress.models[line.model], of_quiet);
      if (i >= own.size()) continue;
      const std::vector<double> rows_of_line = rows_of(own[i], measure, aside);
      const std::string table = script.table(4, rows_of_line);
      pictures::LineStyle bars = line.style;
      bars.dashes = 1;
      bars.size = 0.6;
      series.push_back({table, "1:2:3:4", "yerrorbars", bars});
      pictures::LineStyle plain = line.style;
      plain.mark.reset();
      series.push_back({table, "1:2", "lines", plain});
      for (pictures::PlotSeries& marks : border_marks(script, rows_of_line, range, plain)) series.push_back(std::move(marks));
    }
    if (series.empty()) series.push_back({script.table(2, {}), "1:2", "lines", {.colour = colours::others}});
    script.text(pictures::shortened(curve.name, 26), panel_left + width / 2.0, panel_top - 12, "center font ',12'");
    script.text(pictures::shortened(curve.unit, 30), panel_left + width / 2.0, panel_top + panel_height + 40, "center font ',10'",
                colours::faint_ink);
    script.plot(series);
  }
  return std::move(script).finished();
}

}  // namespace tactile::report
