#include "tactile/pictures/prediction_picture.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <tuple>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/pictures/plot_writer.hpp"

namespace tactile::pictures {
namespace {

constexpr std::string_view unlabelled_colour = "#B8B8B8";

/// A stretch of a row in one colour.
struct Stretch {
  double from = 0, to = 0;  ///< [s]
};

class PredictionScript : public PlotWriter {
  // All in pixels of the picture.
  static constexpr int picture_width = 1100, left = 110, right = 30, top = 76, between_panels = 18, axis_height = 52;
  static constexpr int rate_height = 200, probability_height = 220, row_height = 34, line_height = 19;
  static constexpr std::size_t line_characters = 130;
  static constexpr std::size_t curve_points = 1500;  // finer than pixels, for an SVG is looked at closely

 public:
  explicit PredictionScript(const PredictionPicture& picture)
      : picture_(picture), seconds_(std::max(1e-3, seconds_to(picture.ticks.back().t))) {}

  Plot plot() {
    const int rows = 1 + (picture_.has_labels ? 1 : 0) + (picture_.has_truth ? 1 : 0);
    const int rows_height = rows * row_height;
    const std::vector<std::string> lines = words();
    const int rate_top = top, probability_top = rate_top + rate_height + between_panels;
    const int rows_top = probability_top + probability_height + between_panels, rows_bottom = rows_top + rows_height;
    resize(picture_width, rows_bottom + axis_height + static_cast<int>(lines.size()) * line_height + 18);

    add("set multiplot");
    add("set border 3 lc rgb '{}' lw 0.8", figure_colours::faint_ink);
    add("set tics nomirror scale 0.5 textcolor rgb '{}'", figure_colours::ink);
    add("set grid x y lt 1 lc rgb '#E6E6E6' lw 0.6");
    add("set style data lines");
    write(picture_.title, left, 26, "font ',14' left", figure_colours::ink);
    for (std::size_t i = 0; i < lines.size(); ++i)
      write(lines[i], left - 60, rows_bottom + axis_height + 8 + static_cast<int>(i) * line_height, "left", figure_colours::ink);
    name_intervals();

    begin_panel(rate_top, rate_top + rate_height, false);
    shade_labels();
    add("set ylabel 'events per ms' textcolor rgb '{}'\nset yrange [0:*]", figure_colours::ink);
    add("plot {} lc rgb '{}' lw 1 notitle", line([](const PredictedTick& tick) { return tick.events_per_ms; }),
        figure_colours::ink);

    begin_panel(probability_top, probability_top + probability_height, false);
    shade_labels();
    mark_first_right();
    add("set ylabel 'probability' textcolor rgb '{}'\nset yrange [-0.02:1.02]\nset ytics 0, 0.25, 1", figure_colours::ink);
    add("plot {} lc rgb '{}' lw 1.2 notitle, {} lc rgb '{}' lw 1.2 notitle",
        line([](const PredictedTick& tick) { return tick.press; }), figure_colours::of(Touch::press),
        line([](const PredictedTick& tick) { return tick.slip; }), figure_colours::of(Touch::slip));

    begin_panel(rows_top, rows_bottom, true);
    draw_rows(rows);
    return std::move(*this).finished();
  }

 private:
  CameraTime origin() const { return picture_.first_event.value_or(picture_.ticks.front().t); }
  double seconds_to(CameraTime t) const { return 1e-6 * static_cast<double>(between(origin(), t).count()); }
  double shown(CameraTime t) const { return std::clamp(seconds_to(t), 0.0, seconds_); }
  double pixel_of(double seconds) const { return left + (picture_width - left - right) * seconds / seconds_; }

  /// Over the first panel, each at its onset; in a second row where it would cover the words before.
  void name_intervals() {
    constexpr double character = 8.5, row = 17;  // [px]
    double free_from = 0;
    bool raised = false;
    for (const PredictedInterval& label : picture_.labels) {
      const auto& [interval, words] = std::tie(label.interval, label.words);
      std::string name(name_of(interval.touch));
      if (!words.empty()) name += ": " + words;
      const double x = pixel_of(shown(interval.start));
      raised = x < free_from && !raised;
      free_from = x + character * static_cast<double>(characters_in(name));
      write(name, x, top - 10 - (raised ? row : 0), "left", figure_colours::of(interval.touch));
    }
  }

  template <class ValueOf>
  std::string line(ValueOf value_of) {
    std::vector<PlotPoint> points;
    for (const PredictedTick& tick : picture_.ticks) points.push_back({seconds_to(tick.t), value_of(tick)});
    return table(thinned(points, 0, seconds_, curve_points));
  }

  /// Forgets the settings of the panel before. The picture's own words were drawn with the first.
  void begin_panel(int panel_top, int panel_bottom, bool is_last) {
    if (begun_) add("unset label");
    begun_ = true;
    add("unset object\nunset arrow\nunset ylabel\nset ytics autofreq\nset yrange [*:*]");
    place_panel({.left = left, .top = panel_top, .right = picture_width - right, .bottom = panel_bottom});
    add("set xrange [0:{:.9g}]\nset format x '{}'", seconds_, is_last ? "%g" : "");
    if (is_last)
      add("set xlabel 'time since the first {} [s]' textcolor rgb '{}'", picture_.first_event ? "event" : "full tick",
          figure_colours::ink);
    else
      add("unset xlabel");
  }

  void shade_labels() {
    for (const PredictedInterval& label : picture_.labels) {
      const double from = shown(label.interval.start), to = shown(label.interval.end);
      band(from, to, figure_colours::of_interval(label.interval.touch).area);
      upright(from, fmt::format("lc rgb '{}' lw 0.8", figure_colours::of(label.interval.touch)));
    }
  }

  void mark_first_right() {
    for (const PredictedInterval& label : picture_.labels) {
      if (label.first_right) upright(shown(*label.first_right), fmt::format("dashtype 2 lc rgb '{}' lw 1", figure_colours::ink));
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

  template <class Intervals>
  std::vector<Stretch> stretches_of(Touch touch, const Intervals& intervals) const {
    std::vector<Stretch> stretches;
    for (const TouchInterval& interval : intervals) {
      if (interval.touch == touch) stretches.push_back({shown(interval.start), shown(interval.end)});
    }
    return stretches;
  }

  void draw_rows(int rows) {
    std::vector<TouchInterval> labels;
    for (const PredictedInterval& label : picture_.labels) labels.push_back(label.interval);
    std::string names, boxes;
    int row = 0;
    const auto add_boxes = [&](const std::vector<Stretch>& stretches, std::string_view colour) {
      if (stretches.empty()) return;
      const double middle = rows - 1 - row;
      // Narrower boxes would not be visible.
      const double least = 0.5 * seconds_ / (picture_width - left - right);
      std::vector<double> values;
      for (const Stretch& stretch : stretches) {
        const double from = std::min(stretch.from, stretch.to - least);
        for (const double value : {(from + stretch.to) / 2, middle, from, stretch.to, middle - 0.36, middle + 0.36})
          values.push_back(value);
      }
      boxes += fmt::format(", {} using 1:2:3:4:5:6 with boxxyerror fs solid 1 noborder lc rgb '{}' notitle",
                           table(6, std::move(values)), colour);
    };
    const auto begin_row = [&](std::string_view name) {
      names += fmt::format("{}{} {}", names.empty() ? "" : ", ", plot_text(name), rows - 1 - row);
    };
    begin_row("predicted");
    for (const Touch touch : {Touch::press, Touch::slip}) add_boxes(predicted(touch), figure_colours::of(touch));
    ++row;
    if (picture_.has_labels) {
      begin_row("labelled");
      for (const Touch touch : {Touch::press, Touch::slip}) add_boxes(stretches_of(touch, labels), figure_colours::of(touch));
      ++row;
    }
    if (picture_.has_truth) {
      begin_row("true");
      for (const Touch touch : {Touch::press, Touch::slip})
        add_boxes(stretches_of(touch, picture_.unlabelled), unlabelled_colour);
      for (const Touch touch : {Touch::press, Touch::slip})
        add_boxes(stretches_of(touch, picture_.truth), figure_colours::of(touch));
    }
    add("set yrange [-0.6:{}]\nset ytics ({})", rows - 0.4, names);
    add("unset grid\nset grid x lt 1 lc rgb '#E6E6E6' lw 0.6");
    add("plot {} notitle{}", table(2, {}), boxes);
  }

  std::vector<std::string> words() const {
    const bool has_delays = std::any_of(picture_.labels.begin(), picture_.labels.end(),
                                        [](const PredictedInterval& label) { return !label.words.empty(); });
    std::vector<std::string> remarks{
        std::string("Blue: press, orange: slip") + (picture_.has_labels ? "; shaded: labelled" : "") +
        (has_delays ? ", with the detection delay above" : "") + (picture_.has_truth ? "; grey: unlabelled motion" : "") + "."};
    remarks.insert(remarks.end(), picture_.remarks.begin(), picture_.remarks.end());
    std::vector<std::string> lines;
    for (const std::string& remark : remarks) {
      for (const std::string& line : lines_of(wrapped(remark, 4, line_characters))) lines.push_back(line);
    }
    return lines;
  }

  const PredictionPicture& picture_;
  double seconds_;
  bool begun_ = false;
};

}  // namespace

Plot prediction_plot(const PredictionPicture& picture) {
  if (picture.ticks.empty()) throw Error("prediction: no tick to draw; expected one at least");
  return PredictionScript(picture).plot();
}

void draw_prediction(const PredictionPicture& picture, const std::filesystem::path& file) {
  draw(prediction_plot(picture), file);
}

}  // namespace tactile::pictures
