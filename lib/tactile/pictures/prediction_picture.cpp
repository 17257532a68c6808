#include "tactile/pictures/prediction_picture.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/pictures/plot_script.hpp"

namespace tactile::pictures {
namespace {

constexpr std::string_view unlabelled_colour = "#B8B8B8";

/// A stretch of a row in one colour.
struct Stretch {
  double from = 0, to = 0;  ///< [s]
};

class PredictionScript {
  // All in pixels of the picture.
  static constexpr int left = 104, right = 24, name_row = 18, between_panels = 18, axis_height = 56, line_height = 19;
  static constexpr int rate_height = 170, probability_height = 190, row_height = 34;
  static constexpr std::size_t curve_points = 1500;  // finer than pixels, for an SVG is looked at closely

 public:
  PredictionScript(const PredictionPicture& picture, int width_px)
      : picture_(picture),
        width_px_(width_px),
        seconds_(std::max(1e-3, seconds_to(picture.ticks.back().t))),
        rows_(1 + (picture.has_labels ? 1 : 0) + (picture.has_truth ? 1 : 0)),
        script_(head(), rows_bottom() + axis_height + static_cast<int>(words().size()) * line_height + 18) {}

  Plot plot() && {
    const std::vector<std::string> lines = words();
    for (std::size_t i = 0; i < lines.size(); ++i)
      script_.text(lines[i], 20, rows_bottom() + axis_height + 8 + static_cast<int>(i) * line_height, "left font ',11'");
    name_intervals();

    begin_panel(rate_top(), rate_height);
    shade_reference();
    script_.axes(time_axis(false), {});
    script_.add("set ylabel 'events per ms' textcolor rgb '{}'\nset yrange [0:*]", figure_colours::ink);
    script_.plot(
        {{line([](const PredictedTick& tick) { return tick.events_per_ms; }), "1:2", "lines", {.colour = figure_colours::ink}}});

    begin_panel(probability_top(), probability_height);
    shade_reference();
    mark_first_right();
    script_.axes(time_axis(false), {.begin = -0.02, .end = 1.02, .label = "probability", .tics = "0, 0.25, 0.5, 0.75, 1"});
    script_.plot({{line([](const PredictedTick& tick) { return tick.press; }), "1:2", "lines", line_of(Touch::press)},
                  {line([](const PredictedTick& tick) { return tick.slip; }), "1:2", "lines", line_of(Touch::slip)}});

    begin_panel(rows_top(), rows_ * row_height);
    draw_rows();
    return std::move(script_).finished();
  }

 private:
  static LineStyle line_of(Touch touch) { return {.colour = figure_colours::of(touch), .width = 1.2}; }

  PlotHead head() const {
    PlotHead head(picture_.title, width_px_);
    head.key("press", {.colour = figure_colours::press, .fill = 1});
    head.key("slip", {.colour = figure_colours::slip, .fill = 1});
    const auto& reference = picture_.reference();
    const std::string kind = picture_.has_truth ? "true " : "labelled ";
    for (const Touch touch : {Touch::press, Touch::slip}) {
      const auto of_touch = [touch](const PredictedInterval& one) { return one.interval.touch == touch; };
      if (std::any_of(reference.begin(), reference.end(), of_touch))
        head.key(kind + std::string(name_of(touch)), {.colour = figure_colours::of_interval(touch).area, .fill = 1});
    }
    if (!picture_.unlabelled.empty()) head.key("motion without a label", {.colour = unlabelled_colour, .fill = 1});
    const auto has_words = [](const PredictedInterval& one) { return !one.words.empty(); };
    if (std::any_of(reference.begin(), reference.end(), has_words))
      head.note("Above each " + kind + "touch: its detection delay.");
    return head;
  }

  int rate_top() const { return head().bottom() + 2 * name_row + 12; }
  int probability_top() const { return rate_top() + rate_height + between_panels; }
  int rows_top() const { return probability_top() + probability_height + between_panels; }
  int rows_bottom() const { return rows_top() + rows_ * row_height; }

  CameraTime origin() const { return picture_.first_event.value_or(picture_.ticks.front().t); }
  double seconds_to(CameraTime t) const { return 1e-6 * static_cast<double>(between(origin(), t).count()); }
  double shown(CameraTime t) const { return std::clamp(seconds_to(t), 0.0, seconds_); }
  double pixel_of(double seconds) const { return left + (width_px_ - left - right) * seconds / seconds_; }

  /// Over the first panel, each at its onset; in a second row where it would cover the words before. Words begin further left
  /// where they would leave the figure.
  void name_intervals() {
    constexpr double character = 8.5;  // [px]
    double free_from = 0;
    bool raised = false;
    for (const PredictedInterval& one : picture_.reference()) {
      std::string name(name_of(one.interval.touch));
      if (!one.words.empty()) name += ": " + one.words;
      const double width = character * static_cast<double>(characters_in(name));
      const double x = std::min(pixel_of(shown(one.interval.start)), width_px_ - width);
      raised = x < free_from && !raised;
      free_from = x + width;
      script_.text(name, x, rate_top() - 10 - (raised ? name_row : 0), "left font ',11'", figure_colours::of(one.interval.touch));
    }
  }

  template <class ValueOf>
  std::string line(ValueOf value_of) {
    std::vector<PlotPoint> points;
    for (const PredictedTick& tick : picture_.ticks) points.push_back({seconds_to(tick.t), value_of(tick)});
    return script_.table(thinned(points, 0, seconds_, curve_points));
  }

  void begin_panel(int top, int height) {
    script_.begin_panel({.left = left, .top = top, .right = width_px_ - right, .bottom = top + height});
  }

  PlotAxis time_axis(bool is_last) const {
    return {.begin = 0,
            .end = seconds_,
            .label = !is_last               ? ""
                     : picture_.first_event ? "time since the first event [s]"
                                            : "time since the first full tick [s]",
            .has_labels = is_last};
  }

  void shade_reference() {
    for (const PredictedInterval& one : picture_.reference()) {
      const double from = shown(one.interval.start), to = shown(one.interval.end);
      script_.band(from, to, figure_colours::of_interval(one.interval.touch).area);
      script_.upright(from, fmt::format("lc rgb '{}' lw 0.8", figure_colours::of(one.interval.touch)));
    }
  }

  void mark_first_right() {
    for (const PredictedInterval& one : picture_.reference()) {
      if (one.first_right)
        script_.upright(shown(*one.first_right), fmt::format("dashtype 2 lc rgb '{}' lw 1", figure_colours::ink));
    }
  }

  /// The episodes of a verdict: a tick stands for the time since the one before it.
  std::vector<Stretch> predicted(Touch touch) const {
    const std::vector<PredictedTick>& ticks = picture_.ticks;
    const double tick = ticks.size() > 1 ? seconds_to(ticks[1].t) - seconds_to(ticks[0].t) : seconds_;
    std::vector<Stretch> stretches;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      if (ticks[i].verdict != touch) continue;
      const double to = seconds_to(ticks[i].t);
      if (i > 0 && ticks[i - 1].verdict == touch)
        stretches.back().to = to;
      else
        stretches.push_back({std::max(0.0, to - tick), to});
    }
    return stretches;
  }

  static const TouchInterval& interval_of(const TouchInterval& interval) { return interval; }
  static const TouchInterval& interval_of(const PredictedInterval& one) { return one.interval; }

  template <class Intervals>
  std::vector<Stretch> stretches_of(Touch touch, const Intervals& intervals) const {
    std::vector<Stretch> stretches;
    for (const auto& one : intervals) {
      const TouchInterval& interval = interval_of(one);
      if (interval.touch == touch) stretches.push_back({shown(interval.start), shown(interval.end)});
    }
    return stretches;
  }

  void draw_rows() {
    std::string names;
    std::vector<PlotSeries> series;
    int row = 0;
    const auto add_boxes = [&](const std::vector<Stretch>& stretches, std::string_view colour, double half = 0.36) {
      if (stretches.empty()) return;
      const double middle = rows_ - 1 - row;
      // Narrower boxes would not be visible.
      const double least = 0.5 * seconds_ / (width_px_ - left - right);
      std::vector<double> values;
      for (const Stretch& stretch : stretches) {
        const double from = std::min(stretch.from, stretch.to - least);
        for (const double value : {(from + stretch.to) / 2, middle, from, stretch.to, middle - half, middle + half})
          values.push_back(value);
      }
      series.push_back({script_.table(6, std::move(values)), "1:2:3:4:5:6", "boxxyerror", {.colour = colour, .fill = 1}});
    };
    const auto add_row = [&](std::string_view name, const auto& stretches, double half = 0.36) {
      names += fmt::format("{}{} {}", names.empty() ? "" : ", ", plot_text(name), rows_ - 1 - row);
      for (const Touch touch : {Touch::press, Touch::slip}) add_boxes(stretches(touch), figure_colours::of(touch), half);
      ++row;
    };
    add_row("predicted", [&](Touch touch) { return predicted(touch); });
    if (picture_.has_truth) {
      for (const Touch touch : {Touch::press, Touch::slip})
        add_boxes(stretches_of(touch, picture_.unlabelled), unlabelled_colour);
      add_row("true", [&](Touch touch) { return stretches_of(touch, picture_.truth); });
    }
    if (picture_.has_labels) {
      const double half = picture_.has_truth ? 0.12 : 0.36;
      add_row(
          "labelled", [&](Touch touch) { return stretches_of(touch, picture_.labels); }, half);
    }
    script_.axes(time_axis(true), {.begin = -0.6, .end = rows_ - 0.4, .tics = names});
    script_.add("unset grid\nset grid x lt 1 lc rgb '{}' lw 0.6", figure_colours::grid);
    series.push_back({script_.table(2, {}), "1:2", "lines", line_of(Touch::none)});  // where there is no box
    script_.plot(series);
  }

  std::vector<std::string> words() const {
    const auto characters = static_cast<std::size_t>((width_px_ - 40) / 7.8);
    std::vector<std::string> lines;
    for (const std::string& remark : picture_.remarks) {
      for (const std::string& line : lines_of(wrapped(remark, 4, characters))) lines.push_back(line);
    }
    return lines;
  }

  const PredictionPicture& picture_;
  int width_px_;
  double seconds_;
  int rows_;
  PlotScript script_;
};

}  // namespace

Plot prediction_plot(const PredictionPicture& picture, int width_px) {
  if (picture.ticks.empty()) throw Error("prediction: no tick to draw; expected one at least");
  return PredictionScript(picture, width_px).plot();
}

void draw_prediction(const PredictionPicture& picture, const std::filesystem::path& file) {
  draw(prediction_plot(picture), file);
}

}  // namespace tactile::pictures
