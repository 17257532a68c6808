#include "tactile/report/classifier_plots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/pictures/plot_script.hpp"
#include "tactile/report/figure_parts.hpp"

namespace tactile::report {
namespace {

using pictures::figure_colours::faint_ink;
using pictures::figure_colours::ink;

}  // namespace

pictures::Plot confusion_plot(const std::string& title, const results::Confusion& confusion) {
  constexpr int width = 760, height = 470, left = 130, right = 60, top = 100, below = 40;
  constexpr double field_width = (width - left - right) / 3.0, field_height = (height - top - below) / 3.0;
  pictures::PlotScript script(title, width, height);
  script.text("predicted", (left + width - right) / 2.0, 60, "center font ',13'");
  script.text("true", 24, (top + height - below) / 2.0, "center rotate by 90 font ',13'");
  script.begin_panel({.left = left, .top = top, .right = width - right, .bottom = height - below});
  script.axes({.end = 3}, {.end = 3});
  script.add("unset border\nunset grid\nunset xtics\nunset ytics");
  for (std::size_t i = 0; i < touch_count; ++i) {
    const auto at = static_cast<double>(i) + 0.5;
    script.text(name_of(all_touches[i]), left + at * field_width, top - 16, "center font ',12'");
    script.text(name_of(all_touches[i]), left - 14, top + at * field_height, "right font ',12'");
    const auto& counts = confusion.counts[i];
    const auto row = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    for (std::size_t k = 0; k < touch_count; ++k) {
      const double share = row == 0 ? 0 : static_cast<double>(counts[k]) / static_cast<double>(row);
      // From white to a deep blue.
      const auto mixed = [share](int full) { return static_cast<int>(std::lround(245 + (full - 245) * share)); };
      script.add(
          "set object rectangle from {0}.015, {1}.02 to {0}.985, {1}.98 fillcolor rgb '#{2:02X}{3:02X}{4:02X}' "
          "fillstyle solid noborder",
          k, 2 - i, mixed(0), mixed(58), mixed(130));
      const std::string_view colour = share > 0.5 ? "#FFFFFF" : ink;
      const double x = left + (static_cast<double>(k) + 0.5) * field_width, y = top + at * field_height;
      script.text(row == 0 ? "no sample" : fmt::format("{:.1f} %", 100 * share), x, y - 11, "center font ',16'", colour);
      script.text(fmt::format("{}", counts[k]), x, y + 16, "center font ',12'", colour);
    }
  }
  script.plot({{script.table(2, {}), "1:2", "points", {.colour = ink}}});
  return std::move(script).finished();
}

pictures::Plot reliability_plot(const std::string& title, const std::vector<results::ReliabilityBin>& bins) {
  constexpr int width = 760, left = 116, right = 40, top = 84, gap = 30, upper_height = 380, lower_height = 110, below = 62;
  constexpr int upper_bottom = top + upper_height, lower_top = upper_bottom + gap, bottom = lower_top + lower_height;
  std::vector<double> of_many, of_few, boxes;
  std::uint64_t most = 1;
  double least = 100;
  for (const results::ReliabilityBin& bin : bins) {
    if (bin.samples == 0) continue;
    std::vector<double>& points = bin.samples < few_samples ? of_few : of_many;
    points.insert(points.end(), {percent(bin.confidence), percent(bin.accuracy.value)});
    add_interval(points, bin.accuracy);
    const auto samples = static_cast<double>(bin.samples);
    boxes.insert(boxes.end(), {percent((bin.from + bin.to) / 2), samples, percent(bin.from), percent(bin.to), 0.8, samples});
    most = std::max(most, bin.samples);
    least = std::min(least, percent(bin.from));
  }
  const double begin = std::min(30.0, 10 * std::floor(least / 10));
  std::string decades;
  for (double ten = 1; ten <= static_cast<double>(most); ten *= most >= 1'000'000 ? 100 : 10)
    decades += fmt::format("{}{:.0f}", decades.empty() ? "" : ", ", ten);

  pictures::PlotScript script(title, width, bottom + below);
  script.note(fmt::format("Dashed: perfect calibration. Hollow: fewer than {} samples.", few_samples));
  script.begin_panel({.left = left, .top = top, .right = width - right, .bottom = upper_bottom});
  script.axes({.begin = begin, .end = 101, .has_labels = false}, {.end = 102, .label = "accuracy [%]"});
  script.add("set arrow from first {0:.9g}, first {0:.9g} to first 100, first 100 nohead dt 2 lc rgb '{1}' lw 1.2", begin,
             faint_ink);
  const std::string table = script.table(4, std::move(of_many));
  const auto blue = pictures::figure_colours::network;
  script.plot({{table, "1:2:3:4", "yerrorbars", {.colour = blue, .width = 1.6, .mark = 7, .size = 1.1}},
               {table, "1:2", "lines", {.colour = blue, .width = 1.6}},
               {script.table(4, std::move(of_few)), "1:2:3:4", "yerrorbars", {.colour = blue, .mark = 6, .size = 1.1}}});
  script.begin_panel({.left = left, .top = lower_top, .right = width - right, .bottom = bottom});
  script.add("set logscale y\nset format y '%.0f'");
  script.axes({.begin = begin, .end = 101, .label = "largest probability [%]"},
              {.begin = 0.8, .end = 2.0 * static_cast<double>(most), .label = "samples", .tics = decades});
  script.plot({{script.table(6, std::move(boxes)), "1:2:3:4:5:6", "boxxyerror", {.colour = faint_ink, .fill = 0.6}}});
  return std::move(script).finished();
}

namespace {

constexpr int training_left = 96, training_right = 20, training_gap = 84;
constexpr std::size_t most_named_trainings = 8;

/// The losses and epochs of all trainings, for the axes.
struct TrainingRanges {
  double most_epochs = 1, least_loss = 1e9, greatest_loss = 0;
  AccuracyAxis accuracy{};
  bool has_validation = false;

  explicit TrainingRanges(const std::vector<TrainingCurve>& curves) {
    for (const TrainingCurve& curve : curves) {
      for (const TrainingCurve::Epoch& epoch : curve.epochs) include(epoch);
    }
    if (greatest_loss <= 0) greatest_loss = least_loss = 1;
  }

  void include(const TrainingCurve::Epoch& epoch) {
    most_epochs = std::max(most_epochs, epoch.epoch);
    if (std::isfinite(epoch.loss) && epoch.loss > 0) {
      greatest_loss = std::max(greatest_loss, epoch.loss);
      least_loss = std::min(least_loss, epoch.loss);
    }
    accuracy.include({.value = epoch.accuracy});
    accuracy.include({.value = epoch.validation_accuracy});
    has_validation = has_validation || std::isfinite(epoch.validation_accuracy);
  }
};

/// 1, 2 and 5 of each decade within [least, most], as tics of a logarithmic axis.
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

std::vector<double> values_of(const TrainingCurve& curve) {
  std::vector<double> values;
  for (const TrainingCurve::Epoch& epoch : curve.epochs)
    values.insert(values.end(), {epoch.epoch, epoch.loss, percent(epoch.accuracy), percent(epoch.validation_accuracy)});
  return values;
}

/// One column of every training, named ones over grey ones.
std::vector<pictures::PlotSeries> training_series(pictures::PlotScript& script, const std::vector<std::string>& tables,
                                                  std::string_view columns, bool with_validation) {
  std::vector<pictures::PlotSeries> series;
  for (std::size_t i = tables.size(); i-- > 0;) {
    if (i >= most_named_trainings) {
      series.push_back({tables[i], columns, "lines", {.colour = pictures::figure_colours::others}});
      continue;
    }
    const pictures::LineStyle style = pictures::line_style(i);
    series.push_back({tables[i], columns, "linespoints", style});
    if (with_validation)
      series.push_back({tables[i], "1:4", "points", {.colour = style.colour, .width = 1.6, .mark = 6, .size = 1.1}});
  }
  series.push_back({script.table(4, {}), "1:2", "points", {.colour = ink}});  // where there is none
  return series;
}

/// Names under the panels, in two columns.
void add_training_key(pictures::PlotScript& script, const std::vector<TrainingCurve>& curves, std::size_t named, int key_top,
                      int row) {
  for (std::size_t i = 0; i < named; ++i) {
    const pictures::LineStyle style = pictures::line_style(i);
    const double x = i % 2 == 0 ? training_left : page_width / 2.0 + 20, y = key_top + static_cast<double>(i / 2) * row;
    script.text(pictures::shortened(curves[i].name, 50), x + 56, y, "left font ',12'");
    script.line(x, y, x + 44, y, style.colour, 1.8, style.dashes);
    script.text("", x + 22, y, fmt::format("point pt {} ps 1 lc rgb '{}'", *style.mark, style.colour));
  }
}

}  // namespace

pictures::Plot training_plot(const std::string& title, const std::vector<TrainingCurve>& curves) {
  constexpr int top = 84, panel_height = 320, below = 76, key_row = 24, bottom = top + panel_height;
  constexpr int width = (page_width - training_left - training_right - training_gap) / 2;
  const std::size_t named = std::min(curves.size(), most_named_trainings);
  const TrainingRanges ranges(curves);
  pictures::PlotScript script(title, page_width, bottom + below + static_cast<int>((named + 1) / 2) * key_row + 10);
  script.note(std::string("One line per training") +
              (curves.size() > named ? fmt::format("; grey: {} more", curves.size() - named) : "") +
              (ranges.has_validation ? "; hollow marks: accuracy on the validation samples." : "."));
  std::vector<std::string> tables;
  for (const TrainingCurve& curve : curves) tables.push_back(script.table(4, values_of(curve)));
  const pictures::PlotAxis epochs{.begin = 0.5, .end = ranges.most_epochs + 0.5, .label = "epoch"};
  const double least_loss = ranges.least_loss / 1.3, greatest_loss = ranges.greatest_loss * 1.3;

  script.begin_panel({.left = training_left, .top = top, .right = training_left + width, .bottom = bottom});
  script.add("set logscale y\nset format y '%.3g'");
  script.axes(epochs,
              {.begin = least_loss, .end = greatest_loss, .label = "loss", .tics = decade_tics(least_loss, greatest_loss)});
  script.plot(training_series(script, tables, "1:2", false));

  script.begin_panel(
      {.left = training_left + width + training_gap, .top = top, .right = page_width - training_right, .bottom = bottom});
  script.axes(epochs, {.begin = ranges.accuracy.begin(), .end = ranges.accuracy.end(), .label = "accuracy in training [%]"});
  add_training_key(script, curves, named, bottom + below + 6, key_row);
  script.plot(training_series(script, tables, "1:3", ranges.has_validation));
  return std::move(script).finished();
}

}  // namespace tactile::report
