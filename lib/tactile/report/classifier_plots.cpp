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
  constexpr int width = page_width, left = 110, right = 40, fields_height = 300, below = 24;
  constexpr double field_width = (width - left - right) / 3.0, field_height = fields_height / 3.0;
  const pictures::PlotHead head(title, width);
  const int top = head.bottom() + 58, height = top + fields_height + below;
  pictures::PlotScript script(head, height);
  script.text("predicted", (left + width - right) / 2.0, top - 40, "center font ',13'");
  script.text("true", 24, top + fields_height / 2.0, "center rotate by 90 font ',13'");
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
      // From the paper's colour to the network's.
      script.add(
          "set object rectangle from {0}.015, {1}.02 to {0}.985, {1}.98 fillcolor rgb '{2}' fillstyle transparent solid {3:.3f} "
          "noborder",
          k, 2 - i, pictures::figure_colours::network, 0.06 + 0.94 * share);
      const std::string_view colour = share > 0.5 ? pictures::figure_colours::paper : ink;
      const double x = left + (static_cast<double>(k) + 0.5) * field_width, y = top + at * field_height;
      script.text(row == 0 ? "no sample" : fmt::format("{:.1f} %", 100 * share), x, y - 11, "center font ',16'", colour);
      script.text(fmt::format("{}", counts[k]), x, y + 16, "center font ',12'", colour);
    }
  }
  script.plot({{script.table(2, {}), "1:2", "points", {.colour = ink}}});
  return std::move(script).finished();
}

pictures::Plot reliability_plot(const std::string& title, const std::vector<results::ReliabilityBin>& bins) {
  constexpr int width = page_width, left = 96, right = 24, gap = 30, upper_height = 300, lower_height = 100, below = 60;
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
  for (std::uint64_t ten = 1; ten <= most; ten *= most >= 1'000'000 ? 100 : 10)
    decades += fmt::format("{}{}", decades.empty() ? "" : ", ", ten);

  const auto blue = pictures::figure_colours::network;
  pictures::PlotHead head(title, width);
  head.key("the model", {.colour = blue, .width = 1.6, .mark = 7, .size = 1.1});
  head.key(fmt::format("fewer than {} samples", few_samples), {.colour = blue, .width = 0, .mark = 6, .size = 1.1});
  head.key("perfect calibration", {.colour = faint_ink, .width = 1.2, .dashes = 2});
  const int top = head.bottom() + 14, upper_bottom = top + upper_height, lower_top = upper_bottom + gap;
  const int bottom = lower_top + lower_height;
  pictures::PlotScript script(head, bottom + below);
  script.begin_panel({.left = left, .top = top, .right = width - right, .bottom = upper_bottom});
  script.axes({.begin = begin, .end = 101, .has_labels = false}, {.end = 102, .label = "accuracy [%]"});
  script.add("set arrow from first {0:.9g}, first {0:.9g} to first 100, first 100 nohead dt 2 lc rgb '{1}' lw 1.2", begin,
             faint_ink);
  const std::string table = script.table(4, std::move(of_many));
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

constexpr int training_left = 80, training_right = 16, training_gap = 84;
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

}  // namespace

pictures::Plot training_plot(const std::string& title, const std::vector<TrainingCurve>& curves) {
  constexpr int panel_height = 240, below = 60;
  constexpr int width = (page_width - training_left - training_right - training_gap) / 2;
  const std::size_t named = std::min(curves.size(), most_named_trainings);
  const TrainingRanges ranges(curves);
  pictures::PlotHead head(title, page_width);
  for (std::size_t i = 0; i < named; ++i) head.key(pictures::shortened(curves[i].name, 50), pictures::line_style(i));
  if (curves.size() > named)
    head.key(fmt::format("{} more", curves.size() - named), {.colour = pictures::figure_colours::others});
  if (ranges.has_validation) head.key("accuracy on the validation samples", {.colour = ink, .width = 0, .mark = 6, .size = 1.1});
  const int top = head.bottom() + 16, bottom = top + panel_height;
  pictures::PlotScript script(head, bottom + below);
  std::vector<std::string> tables;
  tables.reserve(curves.size());
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
  script.plot(training_series(script, tables, "1:3", ranges.has_validation));
  return std::move(script).finished();
}

}  // namespace tactile::report
