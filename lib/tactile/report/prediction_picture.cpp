#include "tactile/report/prediction_picture.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <string_view>
#include <tuple>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/report/thinned.hpp"

namespace tactile {
namespace {

// All in pixels of the picture.
constexpr int picture_width = 1100, left = 110, right = 30, top = 76, between_panels = 18, axis_height = 52;
constexpr int rate_height = 200, probability_height = 220, row_height = 34, line_height = 19;
constexpr std::size_t line_characters = 130;
constexpr std::size_t curve_points = 1500;  // finer than pixels, for an SVG is looked at closely

constexpr std::string_view ink = "#303030", faint_ink = "#707070", unlabelled_colour = "#B8B8B8";

struct TouchColours {
  std::string_view area, strong;
};

TouchColours colours_of(Touch touch) {
  return touch == Touch::press ? TouchColours{"#DCE8F8", "#005AC8"} : TouchColours{"#FCE6D6", "#E65A00"};
}

/// A stretch of a row in one colour.
struct Stretch {
  double from = 0, to = 0;  ///< [s]
};

class PredictionScript {
 public:
  explicit PredictionScript(const PredictionPicture& picture)
      : picture_(picture), seconds_(std::max(1e-3, seconds_to(picture.ticks.back().t))) {}

  Plot plot() {
    const int rows = 1 + (picture_.has_labels ? 1 : 0) + (picture_.has_truth ? 1 : 0);
    const int rows_height = rows * row_height;
    const std::vector<std::string> lines = words();
    plot_.width_px = picture_width;
    const int rate_top = top, probability_top = rate_top + rate_height + between_panels;
    const int rows_top = probability_top + probability_height + between_panels, rows_bottom = rows_top + rows_height;
    plot_.height_px = rows_bottom + axis_height + static_cast<int>(lines.size()) * line_height + 18;

    add("set multiplot");
    add("set border 3 lc rgb '{}' lw 0.8", faint_ink);
    add("set tics nomirror scale 0.5 textcolor rgb '{}'", ink);
    add("set grid x y lt 1 lc rgb '#E6E6E6' lw 0.6");
    add("set style data lines");
    text(picture_.title, left, 26, "font ',14' left");
    for (std::size_t i = 0; i < lines.size(); ++i)
      text(lines[i], left - 60, rows_bottom + axis_height + 8 + static_cast<int>(i) * line_height, "left");
    name_intervals();

    begin_panel(rate_top, rate_top + rate_height, false);
    shade_labels();
    add("set ylabel 'events per ms' textcolor rgb '{}'\nset yrange [0:*]", ink);
    add("plot {} lc rgb '{}' lw 1 notitle", line([](const PredictedTick& tick) { return tick.events_per_ms; }), ink);

    begin_panel(probability_top, probability_top + probability_height, false);
    shade_labels();
    mark_first_right();
    add("set ylabel 'probability' textcolor rgb '{}'\nset yrange [-0.02:1.02]\nset ytics 0, 0.25, 1", ink);
    add("plot {} lc rgb '{}' lw 1.2 notitle, {} lc rgb '{}' lw 1.2 notitle",
        line([](const PredictedTick& tick) { return tick.press; }), colours_of(Touch::press).strong,
        line([](const PredictedTick& tick) { return tick.slip; }), colours_of(Touch::slip).strong);

    begin_panel(rows_top, rows_bottom, true);
    draw_rows(rows);
    return std::move(plot_);
  }

 private:
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(plot_.script), format, std::forward<Values>(values)...);
    plot_.script += '\n';
  }

  double seconds_to(CameraTime t) const { return 1e-6 * static_cast<double>(between(picture_.ticks.front().t, t).count()); }
  double shown(CameraTime t) const { return std::clamp(seconds_to(t), 0.0, seconds_); }
  double screen_x(double seconds) const { return (left + (picture_width - left - right) * seconds / seconds_) / picture_width; }
  double screen_y(int y) const { return 1 - static_cast<double>(y) / plot_.height_px; }

  void text(const std::string& words, int x, int y, std::string_view style) {
    add("set label {} at screen {:.6f}, screen {:.6f} {} textcolor rgb '{}'", plot_text(words),
        static_cast<double>(x) / picture_width, screen_y(y), style, ink);
  }

  /// Over the first panel, each at its onset; one that begins where the words before it still go on stands in a second row.
  void name_intervals() {
    constexpr double character = 8.5, row = 17;  // [px]
    double free_from = 0;
    bool raised = false;
    for (const PredictedInterval& label : picture_.labels) {
      const auto& [interval, words] = std::tie(label.interval, label.words);
      std::string name(name_of(interval.touch));
      if (!words.empty()) name += ": " + words;
      const double x = screen_x(shown(interval.start)) * picture_width;
      raised = x < free_from && !raised;
      free_from = x + character * static_cast<double>(characters_in(name));
      add("set label {} at screen {:.6f}, screen {:.6f} left textcolor rgb '{}'", plot_text(name), x / picture_width,
          1 - (top - 10 - (raised ? row : 0)) / plot_.height_px, colours_of(interval.touch).strong);
    }
  }

  std::string table(std::size_t columns, std::vector<double> values) {
    // gnuplot takes no table without rows.
    if (values.empty()) values.assign(columns, std::numeric_limits<double>::quiet_NaN());
    plot_.tables.push_back({.name = fmt::format("t{}", plot_.tables.size()), .columns = columns, .values = std::move(values)});
    return "$" + plot_.tables.back().name;
  }

  template <class ValueOf>
  std::string line(ValueOf value_of) {
    std::vector<PlotPoint> points;
    for (const PredictedTick& tick : picture_.ticks) points.push_back({seconds_to(tick.t), value_of(tick)});
    std::vector<double> values;
    for (const PlotPoint& point : thinned(points, 0, seconds_, curve_points)) {
      values.push_back(point.x);
      values.push_back(point.y);
    }
    return table(2, std::move(values));
  }

  /// Forgets what the panel before had, but for the picture's own words, which went with the first.
  void begin_panel(int panel_top, int panel_bottom, bool is_last) {
    if (begun_) add("unset label");
    begun_ = true;
    add("unset object\nunset arrow\nunset ylabel\nset ytics autofreq\nset yrange [*:*]");
    add("set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}", screen_x(0), screen_x(seconds_));
    add("set tmargin at screen {:.6f}\nset bmargin at screen {:.6f}", screen_y(panel_top), screen_y(panel_bottom));
    add("set xrange [0:{:.9g}]\nset format x '{}'", seconds_, is_last ? "%g" : "");
    if (is_last)
      add("set xlabel 'camera time since the first full tick [s]' textcolor rgb '{}'", ink);
    else
      add("unset xlabel");
  }

  void shade_labels() {
    for (const PredictedInterval& label : picture_.labels) {
      const double from = shown(label.interval.start), to = shown(label.interval.end);
      add("set object rectangle from first {:.9g}, graph 0 to first {:.9g}, graph 1 fillcolor rgb '{}' fillstyle solid noborder "
          "behind",
          from, to, colours_of(label.interval.touch).area);
      add("set arrow from first {0:.9g}, graph 0 to first {0:.9g}, graph 1 nohead lc rgb '{1}' lw 0.8", from,
          colours_of(label.interval.touch).strong);
    }
  }

  void mark_first_right() {
    for (const PredictedInterval& label : picture_.labels) {
      if (!label.first_right) continue;
      add("set arrow from first {0:.9g}, graph 0 to first {0:.9g}, graph 1 nohead dashtype 2 lc rgb '{1}' lw 1",
          shown(*label.first_right), ink);
    }
  }

  /// The episodes of a verdict: a tick stands for the time since the one before it.
  std::vector<Stretch> said(Touch touch) const {
    const std::vector<PredictedTick>& ticks = picture_.ticks;
    const double tick = ticks.size() > 1 ? seconds_to(ticks[1].t) : seconds_;
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
      // What is narrower than half a pixel would not be seen.
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
    begin_row("said");
    for (const Touch touch : {Touch::press, Touch::slip}) add_boxes(said(touch), colours_of(touch).strong);
    ++row;
    if (picture_.has_labels) {
      begin_row("labelled");
      for (const Touch touch : {Touch::press, Touch::slip}) add_boxes(stretches_of(touch, labels), colours_of(touch).strong);
      ++row;
    }
    if (picture_.has_truth) {
      begin_row("true");
      for (const Touch touch : {Touch::press, Touch::slip})
        add_boxes(stretches_of(touch, picture_.unlabelled), unlabelled_colour);
      for (const Touch touch : {Touch::press, Touch::slip})
        add_boxes(stretches_of(touch, picture_.truth), colours_of(touch).strong);
    }
    add("set yrange [-0.6:{}]\nset ytics ({})", rows - 0.4, names);
    add("unset grid\nset grid x lt 1 lc rgb '#E6E6E6' lw 0.6");
    add("plot {} notitle{}", table(2, {}), boxes);
  }

  std::vector<std::string> words() const {
    std::vector<std::string> remarks{std::string("Blue: press, orange: slip") +
                                     (picture_.has_labels ? "; shaded: as labelled" : "") +
                                     (picture_.has_truth ? "; grey: real motion that nobody labels" : "") + "."};
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
  Plot plot_;
};

}  // namespace

Plot prediction_plot(const PredictionPicture& picture) {
  if (picture.ticks.empty()) throw Error("prediction: no tick to draw; expected one at least");
  return PredictionScript(picture).plot();
}

void draw_prediction(const PredictionPicture& picture, const std::filesystem::path& file) {
  draw(prediction_plot(picture), file);
}

}  // namespace tactile
