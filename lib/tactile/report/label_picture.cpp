#include "tactile/report/label_picture.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <regex>
#include <string_view>
#include <tuple>
#include <utility>

#include "tactile/core/text_lines.hpp"
#include "tactile/report/thinned.hpp"

namespace tactile {
namespace {

// All in pixels of the picture.
constexpr int picture_width = 1600, left = 90, right = 30, top = 84, between_panels = 16, axis_height = 46;
constexpr int zoom_left = 1210, panels_right_beside_zooms = 1070;
constexpr int zoom_title = 34, zoom_axis = 46, least_zoom_height = 150, tallest_zoom = 400;
constexpr int line_height = 19;
constexpr std::size_t line_characters = 215, most_lines = 40, most_zooms = 4;
constexpr double zoom_ms = 60;
constexpr double zoom_character = 6.6;  // of what is written over an enlarged onset

constexpr std::string_view ink = "#303030", faint_ink = "#707070";
constexpr std::string_view robot_colour = "#1B7F3B", height_colour = "#8A6D00", video_colour = "#8E24AA", imu_colour = "#00838F";

struct TouchColours {
  std::string_view area, border, onset;  ///< light, where onset and end may lie, and strong
};

TouchColours colours_of(Touch touch) {
  return touch == Touch::press ? TouchColours{"#DCE8F8", "#8DB4EA", "#005AC8"} : TouchColours{"#FCE6D6", "#F4AE80", "#E65A00"};
}

/// Where a panel lies, in pixels from the picture's upper left corner.
struct Frame {
  int left = 0, right = 0, top = 0, bottom = 0;
};

struct SourceEvidence {
  std::string name;
  std::string_view colour;
  std::optional<CameraTime> at;
  const FittedClock* clock = nullptr;  ///< it came through
};

/// What other sources than the events say of an onset.
std::vector<SourceEvidence> evidence_of(const LabelledInterval& interval, const Labels& labels) {
  const Evidence& evidence = interval.evidence;
  const FittedClock* robot = evidence.robot ? labels.robot_clock_at(*evidence.robot) : nullptr;
  const FittedClock* video = evidence.video && labels.video_clock ? &*labels.video_clock : nullptr;
  return {{interval.touch == Touch::slip ? "lift start" : "command", robot_colour, evidence.robot, robot},
          {"video", video_colour, evidence.video, video},
          {"IMU", imu_colour, evidence.imu, nullptr}};
}

class PictureScript {
 public:
  explicit PictureScript(const LabelPicture& picture)
      : picture_(picture), seconds_(std::max(1e-3, seconds_from_begin(picture.end))) {}

  Plot plot() {
    const std::vector<const LabelledInterval*> zooms = chosen_to_enlarge();
    panels_right_ = zooms.empty() ? picture_width - left : panels_right_beside_zooms;
    choose_panels();
    int height = axis_height - between_panels;
    for (const Panel& panel : panels_) height += panel.height + between_panels;
    const int for_zooms = static_cast<int>(zooms.size()) * (least_zoom_height + zoom_title + zoom_axis);
    if (for_zooms > height) {
      // Rows of outputs are as high as they need to be, whatever the height.
      const auto grows = [](const Panel& panel) { return panel.kind != TraceKind::stage_output; };
      const auto growing = static_cast<int>(std::count_if(panels_.begin(), panels_.end(), grows));
      for (Panel& panel : panels_) panel.height += grows(panel) ? (for_zooms - height) / growing : 0;
      height = for_zooms;
    }
    const std::vector<Line> lines = words();
    plot_.width_px = picture_width;
    plot_.height_px = top + height + 16 + static_cast<int>(lines.size()) * line_height + 14;

    add("set multiplot");
    add("set border 3 lc rgb '{}' lw 0.8", faint_ink);
    add("set tics nomirror scale 0.5 textcolor rgb '{}'", ink);
    add("set grid x y lt 1 lc rgb '#E6E6E6' lw 0.6");
    add("set style data lines");
    add("set style textbox opaque noborder margins 0.4,0.2 fillcolor rgb 'white'");
    text(picture_.title, left, 28, "font ',14' left", ink);
    for (std::size_t i = 0; i < lines.size(); ++i)
      text(lines[i].words, left - 60, top + height + 30 + static_cast<int>(i) * line_height, "left", lines[i].colour);
    int y = top;
    for (const Panel& panel : panels_) {
      const Frame frame{left, panels_right_, y, y + panel.height};
      const bool last = &panel == &panels_.back();
      begin_panel(frame, 0, seconds_);
      if (last)
        add("set xlabel 'camera time since the first event [s]' textcolor rgb '{}'", ink);
      else
        add("unset xlabel");
      add("set format x '{}'", last ? "%g" : "");
      mark_intervals(panel.kind);
      (this->*panel.draw)(frame);
      y = frame.bottom + between_panels;
    }
    const int share = zooms.empty() ? 0 : std::min(tallest_zoom, height / static_cast<int>(zooms.size()));
    for (std::size_t i = 0; i < zooms.size(); ++i) {
      const int zoom_top = top - 20 + static_cast<int>(i) * share;
      draw_zoom(*zooms[i], {zoom_left, picture_width - right, zoom_top + zoom_title, zoom_top + share - zoom_axis + 20},
                i + 1 == zooms.size());
    }
    return std::move(plot_);
  }

 private:
  struct Panel {
    std::optional<TraceKind> kind;  ///< nothing: the events'
    int height = 0;
    void (PictureScript::*draw)(const Frame&) = nullptr;
  };
  struct Line {
    std::string words;
    std::string_view colour;
  };

  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(plot_.script), format, std::forward<Values>(values)...);
    plot_.script += '\n';
  }

  double seconds_from_begin(CameraTime t) const { return 1e-6 * static_cast<double>(between(picture_.begin, t).count()); }
  /// Held within what is shown.
  double shown(CameraTime t) const { return std::clamp(seconds_from_begin(t), 0.0, seconds_); }

  void text(const std::string& words, int x, int y, std::string_view style, std::string_view colour) {
    add("set label {} at screen {:.6f}, screen {:.6f} {} textcolor rgb '{}'", plot_text(words),
        static_cast<double>(x) / plot_.width_px, 1 - static_cast<double>(y) / plot_.height_px, style, colour);
  }

  std::string table(const std::vector<PlotPoint>& points) {
    PlotTable table{.name = fmt::format("t{}", plot_.tables.size()), .columns = 2, .values = {}};
    table.values.reserve(2 * points.size());
    for (const PlotPoint& point : points) {
      table.values.push_back(point.x);
      table.values.push_back(point.y);
    }
    // gnuplot takes no table without rows.
    if (points.empty()) table.values = {0.0, std::numeric_limits<double>::quiet_NaN()};
    plot_.tables.push_back(std::move(table));
    return "$" + plot_.tables.back().name;
  }

  /// Forgets what the panel before had, but for the picture's own words, which went with the first.
  void begin_panel(const Frame& frame, double x_low, double x_high) {
    if (begun_) add("unset label");
    begun_ = true;
    add("unset arrow\nunset object\nunset key\nunset ylabel\nunset y2label\nunset y2tics\nset ytics autofreq\nset xtics "
        "autofreq");
    add("set yrange [*:*]\nset border 3");
    add("set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}", static_cast<double>(frame.left) / plot_.width_px,
        static_cast<double>(frame.right) / plot_.width_px);
    add("set tmargin at screen {:.6f}\nset bmargin at screen {:.6f}", 1 - static_cast<double>(frame.top) / plot_.height_px,
        1 - static_cast<double>(frame.bottom) / plot_.height_px);
    add("set xrange [{:.9g}:{:.9g}]", x_low, x_high);
    pixel_ = (x_high - x_low) / (frame.right - frame.left);
  }

  void band(double from, double to, std::string_view colour) {
    add("set object rectangle from first {:.9g}, graph 0 to first {:.9g}, graph 1 fillcolor rgb '{}' fillstyle solid noborder "
        "behind",
        from, to, colour);
  }
  void upright(double x, std::string_view style) {
    add("set arrow from first {0:.9g}, graph 0 to first {0:.9g}, graph 1 nohead {1}", x, style);
  }

  /// Presses and slips over the whole panel, and what its own source says of them.
  void mark_intervals(std::optional<TraceKind> kind) {
    for (const LabelledInterval& interval : picture_.labels.intervals)
      band(shown(interval.start.at), shown(interval.end.at), colours_of(interval.touch).area);
    for (const LabelledInterval& interval : picture_.labels.intervals) {
      const TouchColours colours = colours_of(interval.touch);
      for (const UncertainTime& edge : {interval.start, interval.end})
        band(std::min(shown(edge.low), shown(edge.at) - pixel_), std::max(shown(edge.high), shown(edge.at) + pixel_),
             colours.border);
      upright(shown(interval.start.at), fmt::format("front lc rgb '{}' lw 1.2", colours.onset));
      const bool has_stage = std::any_of(picture_.traces.begin(), picture_.traces.end(),
                                         [](const Trace& trace) { return trace.kind == TraceKind::stage_output; });
      const TraceKind robot_panel = interval.touch == Touch::press && has_stage ? TraceKind::stage_output : TraceKind::tcp_speed;
      const std::array<std::pair<TraceKind, std::optional<CameraTime>>, 3> own{
          {{robot_panel, interval.evidence.robot},
           {TraceKind::acceleration, interval.evidence.imu},
           {TraceKind::video_energy, interval.evidence.video}}};
      for (const auto& [panel, at] : own) {
        if (at && panel == kind) upright(shown(*at), "front lc rgb 'black' dt (4,3) lw 1.2");
      }
    }
  }

  /// As many as have room, by time: slips first, then what is flagged, then the first presses.
  std::vector<const LabelledInterval*> chosen_to_enlarge() const {
    const Labels& labels = picture_.labels;
    std::vector<const LabelledInterval*> chosen;
    for (const LabelledInterval& interval : labels.intervals) chosen.push_back(&interval);
    const auto index_of = [&](const LabelledInterval* interval) {
      return static_cast<std::size_t>(interval - labels.intervals.data());
    };
    const auto rank = [&](const LabelledInterval* interval) {
      return interval->touch == Touch::slip ? 0 : labels.interval_is_flagged(index_of(interval)) ? 1 : 2;
    };
    std::stable_sort(chosen.begin(), chosen.end(), [&](const auto* a, const auto* b) { return rank(a) < rank(b); });
    chosen.resize(std::min(chosen.size(), most_zooms));
    std::sort(chosen.begin(), chosen.end(), [&](const auto* a, const auto* b) { return index_of(a) < index_of(b); });
    return chosen;
  }

  void choose_panels() {
    panels_ = {{std::nullopt, 240, &PictureScript::draw_events}};
    const std::array<std::tuple<TraceKind, int, void (PictureScript::*)(const Frame&)>, 4> others{
        {{TraceKind::tcp_speed, 170, &PictureScript::draw_robot},
         {TraceKind::stage_output, 16 + 26 * std::max(1, static_cast<int>(outputs().size())), &PictureScript::draw_outputs},
         {TraceKind::acceleration, 130, &PictureScript::draw_imu},
         {TraceKind::video_energy, 130, &PictureScript::draw_video}}};
    for (const auto& [kind, height, draw] : others) {
      const bool there = !traces_of(kind).empty() || (kind == TraceKind::tcp_speed && !traces_of(TraceKind::tcp_height).empty());
      if (there) panels_.push_back({kind, height, draw});
    }
  }

  std::vector<const Trace*> traces_of(TraceKind kind) const {
    std::vector<const Trace*> traces;
    for (const Trace& trace : picture_.traces) {
      if (trace.kind == kind && !trace.t.empty()) traces.push_back(&trace);
    }
    return traces;
  }

  struct ValueRange {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    void include(double value) {
      if (!std::isfinite(value)) return;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  };

  std::vector<PlotPoint> points_of(const Trace& trace, ValueRange& range) const {
    std::vector<PlotPoint> points;
    points.reserve(trace.t.size());
    for (std::size_t i = 0; i < std::min(trace.t.size(), trace.values.size()); ++i)
      points.push_back({seconds_from_begin(trace.t[i]), trace.values[i]});
    points = thinned(points, 0, seconds_, static_cast<std::size_t>(panels_right_ - left));
    for (const PlotPoint& point : points) range.include(point.y);
    return points;
  }

  /// An axis that shows the range with some room, and at least `least` of it, so that noise alone does not fill the panel.
  void set_range(std::string_view axis, ValueRange range, double least) {
    if (range.low > range.high) range = {0, 0};
    const double lacking = std::max(0.0, least - (range.high - range.low)), room = 0.06 * std::max(least, range.high - range.low);
    add("set {}range [{:.9g}:{:.9g}]", axis, range.low - lacking / 2 - room, range.high + lacking / 2 + room);
  }

  /// Events per ms, of which the square root is drawn, so that quiet and motion are both seen: its noise is the same everywhere.
  /// Bins of about `bin`, between begin and end in microseconds from the rate's begin.
  std::vector<PlotPoint> rate_in(microseconds bin, double from_us, double to_us, double unit_us, double zero_us) const {
    const EventRate& rate = picture_.rate;
    const auto own_bin = static_cast<double>(rate.bin.count());
    const auto together = static_cast<std::size_t>(std::max(1.0, std::round(static_cast<double>(bin.count()) / own_bin)));
    const auto index_of = [&](double us) {
      return static_cast<std::size_t>(std::clamp(us / own_bin, 0.0, static_cast<double>(rate.counts.size())));
    };
    std::vector<PlotPoint> points;
    const double length_ms = own_bin * static_cast<double>(together) / 1000;
    for (std::size_t i = index_of(from_us) / together * together; i < index_of(to_us); i += together) {
      const std::size_t end = std::min(i + together, rate.counts.size());
      double events = 0;
      for (std::size_t k = i; k < end; ++k) events += rate.counts[k];
      if (end < i + together) events *= static_cast<double>(together) / static_cast<double>(end - i);
      const double middle_us = own_bin * (static_cast<double>(i) + static_cast<double>(together) / 2);
      points.push_back({(middle_us - zero_us) / unit_us, std::sqrt(events / length_ms)});
    }
    return points;
  }

  static double highest_of(const std::vector<PlotPoint>& points) {
    double highest = 0;
    for (const PlotPoint& point : points) highest = std::max(highest, point.y);
    return highest > 0 ? highest : 1;
  }

  /// Marks an axis of square roots by what they are roots of.
  void square_tics(double highest) {
    std::string tics = "'0' 0";
    double last = 0;
    for (double decade = 1e-3; decade <= highest * highest; decade *= 10) {
      for (const double step : {1.0, 2.0, 5.0}) {
        const double root = std::sqrt(step * decade);
        if (root > highest || root - last < 0.12 * highest) continue;
        tics += fmt::format(", '{:g}' {:.9g}", step * decade, root);
        last = root;
      }
    }
    add("set ytics ({})", tics);
  }

  void draw_events(const Frame& frame) {
    const double zero_us = static_cast<double>(between(picture_.rate.begin, picture_.begin).count());
    const std::vector<PlotPoint> points = rate_in(microseconds(2'000), zero_us, zero_us + 1e6 * seconds_, 1e6, zero_us);
    const double highest = 1.05 * highest_of(points);
    add("set yrange [0:{:.9g}]", highest);
    square_tics(highest);
    add("set ylabel 'events per ms' textcolor rgb '{}'", ink);
    name_intervals_over(frame);
    add("plot {} lc rgb '{}' lw 1 notitle",
        table(thinned(points, 0, seconds_, static_cast<std::size_t>(frame.right - frame.left))), ink);
  }

  /// Names stand above the panel, where nothing crosses them, in as many rows as keep them apart.
  void name_intervals_over(const Frame& frame) {
    constexpr double character = 8;
    std::vector<double> row_ends;
    for (const LabelledInterval& interval : picture_.labels.intervals) {
      const double width = character * static_cast<double>(characters_in(interval.id));
      const double at = std::min(frame.left + shown(interval.start.at) / pixel_, frame.right - width);
      const auto free = std::find_if(row_ends.begin(), row_ends.end(), [&](double end) { return end + character < at; });
      const auto row = free - row_ends.begin();
      if (free == row_ends.end()) row_ends.push_back(0);
      row_ends[static_cast<std::size_t>(row)] = at + width;
      if (row < 3)
        text(interval.id, static_cast<int>(at), frame.top - 9 - 15 * static_cast<int>(row), "left",
             colours_of(interval.touch).onset);
    }
  }

  void draw_robot(const Frame&) {
    std::string curves;
    ValueRange speeds{0, 0}, heights;
    const auto curve = [&](const Trace& trace, ValueRange& range, std::string_view axes, std::string_view colour) {
      curves += fmt::format("{}{} axes {} lc rgb '{}' lw 1.5 notitle", curves.empty() ? "" : ", ", table(points_of(trace, range)),
                            axes, colour);
    };
    for (const Trace* trace : traces_of(TraceKind::tcp_height)) curve(*trace, heights, "x1y2", height_colour);
    if (!curves.empty()) {
      add("set y2tics\nset border 11\nset y2label 'TCP height [mm]' offset 0.5,0 textcolor rgb '{}'", height_colour);
      set_range("y2", heights, 5);
    }
    for (const Trace* trace : traces_of(TraceKind::tcp_speed)) curve(*trace, speeds, "x1y1", robot_colour);
    set_range("y", speeds, 5);
    add("set ylabel 'TCP speed [mm/s]' textcolor rgb '{}'", robot_colour);
    add("plot {}", curves);
  }

  /// Names of the outputs, each once: a log in several pieces has a trace of it in each.
  std::vector<std::string> outputs() const {
    std::vector<std::string> names;
    for (const Trace* trace : traces_of(TraceKind::stage_output)) {
      if (std::find(names.begin(), names.end(), trace->name) == names.end()) names.push_back(trace->name);
    }
    return names;
  }

  void draw_outputs(const Frame&) {
    const std::vector<std::string> names = outputs();
    std::string curves, tics;
    for (std::size_t i = 0; i < names.size(); ++i) {
      // Each within its row, whatever its values are; where its log ends nobody knows them.
      ValueRange range;
      std::vector<std::vector<PlotPoint>> pieces;
      for (const Trace* trace : traces_of(TraceKind::stage_output)) {
        if (trace->name == names[i]) pieces.push_back(points_of(*trace, range));
      }
      const double row = static_cast<double>(names.size() - 1 - i);
      // One that never changes lies low where it is 0, else high.
      const double low = range.high > range.low ? range.low : std::min(0.0, range.low);
      const double span = range.high > low ? range.high - low : 1;
      for (std::vector<PlotPoint>& points : pieces) {
        for (PlotPoint& point : points) point.y = row + 0.15 + 0.7 * (point.y - low) / span;
        curves +=
            fmt::format("{}{} with steps lc rgb '{}' lw 1.5 notitle", curves.empty() ? "" : ", ", table(points), robot_colour);
      }
      tics += fmt::format("{}{} {}", i > 0 ? ", " : "", plot_text(short_name(names[i])), row + 0.5);
    }
    add("set yrange [0:{}]\nset ytics ({}) scale 0", names.size(), tics);
    add("plot {}", curves);
    add("set tics scale 0.5");
  }

  /// A name that fits beside the panel.
  static std::string short_name(const std::string& name) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 4> shorter{{{"digital output ", "output "},
                                                                                    {"output_bit_register_", "bit reg. "},
                                                                                    {"output_int_register_", "int reg. "},
                                                                                    {"output_double_register_", "reg. "}}};
    for (const auto& [begin, instead] : shorter) {
      if (name.starts_with(begin)) return std::string(instead) + name.substr(begin.size());
    }
    constexpr std::size_t most = 11;
    return name.size() <= most ? name : name.substr(0, most - 2) + "..";
  }

  void draw_imu(const Frame&) {
    constexpr std::array<std::string_view, 3> colours{"#00838F", "#C2185B", "#7A7A00"};
    std::string curves;
    const std::vector<const Trace*> traces = traces_of(TraceKind::acceleration);
    ValueRange range;
    for (std::size_t i = 0; i < traces.size(); ++i) {
      curves += fmt::format("{}{} lc rgb '{}' lw 1 title {}", i > 0 ? ", " : "", table(points_of(*traces[i], range)),
                            colours[i % colours.size()], plot_text(traces[i]->name));
    }
    set_range("y", range, 0.02);
    if (traces.size() > 1) add("set key at graph 0.995, graph 0.97 right top horizontal samplen 1.5 width 1");
    add("set ylabel 'IMU [g]' textcolor rgb '{}'", imu_colour);
    add("plot {}", curves);
  }

  void draw_video(const Frame&) {
    std::string curves;
    ValueRange range{0, 0};
    for (const Trace* trace : traces_of(TraceKind::video_energy)) {
      curves += fmt::format("{}{} lc rgb '{}' lw 1.2 notitle", curves.empty() ? "" : ", ", table(points_of(*trace, range)),
                            video_colour);
    }
    set_range("y", range, 1e-9);
    add("set ylabel 'video energy' textcolor rgb '{}'", video_colour);
    add("plot {}", curves);
  }

  static std::string signed_ms(double value) { return fmt::format("{}{:.1f}", value < 0 ? "−" : "+", std::abs(value)); }

  /// An onset with 60 ms before and behind it, in ms from it.
  void draw_zoom(const LabelledInterval& interval, const Frame& frame, bool last) {
    const auto ms_from_onset = [&](CameraTime t) { return 1e-3 * static_cast<double>(between(interval.start.at, t).count()); };
    begin_panel(frame, -zoom_ms, zoom_ms);
    const double zero_us = static_cast<double>(between(picture_.rate.begin, interval.start.at).count());
    const auto rate_by = [&](microseconds bin) {
      return rate_in(bin, zero_us - 1000 * (zoom_ms + 2), zero_us + 1000 * (zoom_ms + 2), 1000, zero_us);
    };
    const std::vector<PlotPoint> fine = rate_by(picture_.rate.bin), coarse = rate_by(microseconds(1'000));
    const std::vector<SourceEvidence> evidence = evidence_of(interval, picture_.labels);
    // Room for what is written over the rate.
    double written_px = 8;
    for (const SourceEvidence& source : evidence) written_px += source.at ? height_of(source) : 0;
    const double highest =
        std::max(highest_of(coarse), 0.8 * highest_of(fine)) / std::max(0.3, 1 - written_px / (frame.bottom - frame.top));
    add("set yrange [0:{:.9g}]", highest);
    square_tics(highest);
    add("set format x '%g'\nset xtics 20");
    if (last)
      add("set xlabel 'ms from the onset' textcolor rgb '{}'", ink);
    else
      add("unset xlabel");
    add("set ylabel 'events per ms' textcolor rgb '{}'", ink);

    const TouchColours colours = colours_of(interval.touch);
    const auto held = [](double ms) { return std::clamp(ms, -zoom_ms, zoom_ms); };
    band(0, held(ms_from_onset(interval.end.at)), colours.area);
    const double low = ms_from_onset(interval.start.low), high = ms_from_onset(interval.start.high);
    band(std::min(held(low), -pixel_ / 2), std::max(held(high), pixel_ / 2), colours.border);
    upright(0, fmt::format("back lc rgb '{}' lw 1.2", colours.onset));
    double row_px = 10;
    for (const SourceEvidence& source : evidence) {
      if (!source.at) continue;
      mark_evidence(source, ms_from_onset(*source.at), row_px, frame);
      row_px += height_of(source);
    }
    const bool flagged =
        picture_.labels.interval_is_flagged(static_cast<std::size_t>(&interval - picture_.labels.intervals.data()));
    text(fmt::format("{} at {:.4f} s, 95 %: {} to {} ms{}{}", interval.id, seconds_from_begin(interval.start.at), signed_ms(low),
                     signed_ms(high), interval.confirmed ? ", confirmed" : "", flagged ? ", flagged" : ""),
         frame.left - 40, frame.top - 13, "left", colours.onset);
    add("plot {} with points pt 7 ps 0.22 lc rgb '#9A9A9A' notitle, {} with histeps lc rgb '{}' lw 1.1 notitle", table(fine),
        table(coarse), ink);
  }

  /// Of what is written of it in a panel [px].
  static double height_of(const SourceEvidence& source) { return source.clock == nullptr ? 16 : 24; }

  void mark_evidence(const SourceEvidence& source, double ms, double row_px, const Frame& frame) {
    const auto graph_y = [&](double px) { return 1 - px / (frame.bottom - frame.top); };
    const bool inside = std::abs(ms) <= zoom_ms;
    std::string words = fmt::format("{} {} ms", source.name, signed_ms(ms));
    // Written away from the onset's line where there is room, on a ground of its own: other sources' lines pass behind it.
    const double room_ms = (zoom_character * static_cast<double>(characters_in(words)) + 8) * pixel_;
    double x = ms + 1.2;
    bool to_left = ms < 0 ? ms - room_ms > -zoom_ms : ms + room_ms > zoom_ms;
    if (inside) {
      upright(ms, fmt::format("back lc rgb '{}' dt (4,3) lw 1.3", source.colour));
      if (to_left) x = ms - 1.2;
    } else {
      to_left = ms > 0;
      x = to_left ? zoom_ms - 1 : -zoom_ms + 1;
      words = to_left ? words + " →" : "← " + words;
    }
    add("set label {} at first {:.9g}, graph {:.6f} {} font ',9' front boxed textcolor rgb '{}'", plot_text(words), x,
        graph_y(row_px), to_left ? "right" : "left", source.colour);
    if (source.clock == nullptr || !inside) return;
    // Its clock may be off by so much.
    const auto offset = static_cast<double>(source.clock->relation.offset_us);
    const double low = ms + 1e-3 * (static_cast<double>(source.clock->offset_low_us) - offset);
    const double high = ms + 1e-3 * (static_cast<double>(source.clock->offset_high_us) - offset);
    add("set arrow from first {:.9g}, graph {:.6f} to first {:.9g}, graph {:.6f} nohead front lc rgb '{}' lw 3",
        std::clamp(low, -zoom_ms, zoom_ms), graph_y(row_px + 11), std::clamp(high, -zoom_ms, zoom_ms), graph_y(row_px + 11),
        source.colour);
  }

  static std::string clock_words(std::string_view whose, const FittedClock& clock) {
    const auto offset = static_cast<double>(clock.relation.offset_us);
    return fmt::format("{} clock: {}, {} anchor{}; offset {} to {} ms (95 %), residual {:.1f} ms.", whose,
                       clock.method.empty() ? "method not told" : clock.method, clock.anchors, clock.anchors == 1 ? "" : "s",
                       signed_ms(1e-3 * (static_cast<double>(clock.offset_low_us) - offset)),
                       signed_ms(1e-3 * (static_cast<double>(clock.offset_high_us) - offset)), 1e-3 * clock.residual_us);
  }

  /// A sentence of labels.json with its camera times as the axis counts them: "at 1706024628624000 us" is "at 1.2275 s".
  std::string as_seen_here(const std::string& sentence) const {
    static const std::regex time(R"((\bat |\()(-?[0-9]{1,18}) us\b)");
    std::string seen;
    auto rest = sentence.begin();
    for (std::sregex_iterator found(sentence.begin(), sentence.end(), time), end; found != end; ++found) {
      seen.append(rest, (*found)[0].first);
      rest = (*found)[0].second;
      seen += (*found)[1].str() + fmt::format("{:.4f} s", seconds_from_begin(camera_time(std::stoll((*found)[2].str()))));
    }
    return seen.append(rest, sentence.end());
  }

  /// What stands under the panels.
  std::vector<Line> words() const {
    const Labels& labels = picture_.labels;
    std::vector<Line> lines;
    const auto say = [&](const std::string& sentence, std::string_view colour) {
      for (std::string& line : lines_of(wrapped(as_seen_here(sentence), 4, line_characters))) {
        // A word that is longer than a line is cut.
        while (characters_in(line) > line_characters) {
          std::size_t bytes = line_characters;
          while (characters_in(std::string_view(line).substr(0, bytes)) < line_characters ||
                 (static_cast<unsigned char>(line[bytes]) & 0xC0U) == 0x80U)
            ++bytes;
          lines.push_back({line.substr(0, bytes), colour});
          line.erase(0, bytes);
        }
        lines.push_back({std::move(line), colour});
      }
    };
    say("Blue: press, orange: slip; darker where onset and end may lie (95 %). Dashed: what a source says of an onset; the bar "
        "at "
        "it: what its clock leaves open (95 %).",
        faint_ink);
    for (const FittedClock& clock : labels.robot_clocks) say(clock_words("Robot", clock), ink);
    if (labels.video_clock) say(clock_words("Video", *labels.video_clock), ink);
    const std::array<std::pair<TraceKind, std::string_view>, 4> kinds{{{TraceKind::tcp_speed, "robot"},
                                                                       {TraceKind::stage_output, "stage output"},
                                                                       {TraceKind::acceleration, "IMU"},
                                                                       {TraceKind::video_energy, "video"}}};
    std::string missing;
    for (const auto& [kind, name] : kinds) {
      const bool there =
          std::any_of(panels_.begin(), panels_.end(), [wanted = kind](const Panel& panel) { return panel.kind == wanted; });
      if (!there) missing += fmt::format("{}{}", missing.empty() ? "" : ", ", name);
    }
    if (!missing.empty()) say(fmt::format("Not shown, for the run has none or no clock relates it: {}.", missing), ink);
    if (labels.intervals.size() > most_zooms) {
      const std::size_t more = labels.intervals.size() - most_zooms;
      say(more == 1 ? "1 onset is not shown enlarged." : fmt::format("{} onsets are not shown enlarged.", more), ink);
    }
    for (const std::string& remark : picture_.remarks) say(remark, ink);
    if (labels.flags.empty()) say("Nothing is flagged.", ink);
    for (const LabelFlag& flag : labels.flags) {
      const std::string of = flag.interval_index ? labels.intervals.at(*flag.interval_index).id + ": " : "";
      say((flag.confirmed ? "Flag lifted by a person: " : "Flagged: ") + of + flag.reason,
          flag.confirmed ? faint_ink : "#B00000");
    }
    if (lines.size() > most_lines) {
      const std::size_t more = lines.size() - most_lines + 1;
      lines.resize(most_lines - 1);
      lines.push_back({fmt::format("... and {} more lines, as labels.json has them", more), ink});
    }
    return lines;
  }

  const LabelPicture& picture_;
  double seconds_;
  int panels_right_ = 0;
  double pixel_ = 0;  ///< how much of the axis of the panel at hand it is
  bool begun_ = false;
  std::vector<Panel> panels_;
  Plot plot_;
};

}  // namespace

Plot label_plot(const LabelPicture& picture) { return PictureScript(picture).plot(); }

void draw_label_picture(const LabelPicture& picture, const std::filesystem::path& file) { draw(label_plot(picture), file); }

}  // namespace tactile
