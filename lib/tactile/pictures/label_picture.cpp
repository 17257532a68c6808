#include "tactile/pictures/label_picture.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <regex>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "tactile/core/text_lines.hpp"
#include "tactile/pictures/label_script.hpp"
#include "tactile/pictures/label_zoom.hpp"
#include "tactile/pictures/thinned.hpp"

namespace tactile::pictures {
namespace {

// All in pixels of the picture.
constexpr int picture_width = 1600, left = 90, right = 30, top = 84, between_panels = 16, axis_height = 46;
constexpr int zoom_left = 1210, panels_right_beside_zooms = 1070;
constexpr int zoom_title = 34, zoom_axis = 46, least_zoom_height = 150, tallest_zoom = 400;
constexpr int line_height = 19;

constexpr std::size_t line_characters = 215, most_lines = 40;

std::string clock_words(std::string_view whose, const alignment::FittedClock& clock) {
  const auto offset = static_cast<double>(clock.relation.offset_us);
  const std::string drift =
      clock.drift_within_ppm > 0 ? fmt::format(" where it was found, drift within ±{:.1f} %", 1e-4 * clock.drift_within_ppm) : "";
  return fmt::format("{} clock: {}; offset {} to {} ms (95 %){}.", whose, clock.method.empty() ? "unknown method" : clock.method,
                     signed_ms(1e-3 * (static_cast<double>(clock.offset_low_us) - offset)),
                     signed_ms(1e-3 * (static_cast<double>(clock.offset_high_us) - offset)), drift);
}

/// A sentence of labels.json with its camera times as the axis counts them: "at 1706024628624000 us" is "at 1.2275 s".
std::string with_shown_times(const LabelScript& script, const std::string& sentence) {
  static const std::regex time(R"((\bat |\()(-?[0-9]{1,18}) us\b)");
  std::string seen;
  auto rest = sentence.begin();
  for (std::sregex_iterator found(sentence.begin(), sentence.end(), time), end; found != end; ++found) {
    seen.append(rest, (*found)[0].first);
    rest = (*found)[0].second;
    seen += (*found)[1].str() + fmt::format("{:.4f} s", script.seconds_from_begin(camera_time(std::stoll((*found)[2].str()))));
  }
  return seen.append(rest, sentence.end());
}

/// A line of words under the panels of a label picture.
struct LabelNote {
  std::string words;
  std::string_view colour;
};

/// The legend, clocks, missing signals, remarks and flags, at most 40 lines.
/// @param shown  the panels of the picture, that of the events aside
std::vector<LabelNote> label_notes(const LabelScript& script, std::span<const TraceKind> shown) {
  const labels::Labels& labels = script.picture().labels;
  std::vector<LabelNote> lines;
  const auto say = [&](const std::string& sentence, std::string_view colour) {
    for (std::string& line : lines_of(wrapped(with_shown_times(script, sentence), 4, line_characters))) {
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
  say("Blue: press. Orange: slip. Darker: 95 % interval of onset and end. Grey: release. Dotted: evidence of another source, "
      "with a "
      "bar for the uncertainty of its clock (95 %).",
      figure_colours::faint_ink);
  for (const alignment::FittedClock& clock : labels.robot_clocks) say(clock_words("Robot", clock), figure_colours::ink);
  if (labels.video_clock) say(clock_words("Video", *labels.video_clock), figure_colours::ink);
  const std::array<std::pair<TraceKind, std::string_view>, 4> kinds{{{TraceKind::tcp_speed, "robot"},
                                                                     {TraceKind::stage_output, "stage output"},
                                                                     {TraceKind::acceleration, "IMU"},
                                                                     {TraceKind::video_energy, "video"}}};
  std::string missing;
  for (const auto& [kind, name] : kinds) {
    if (std::find(shown.begin(), shown.end(), kind) == shown.end())
      missing += fmt::format("{}{}", missing.empty() ? "" : ", ", name);
  }
  if (!missing.empty())
    say(fmt::format("Not shown, since the run has none or their clock is not fitted: {}.", missing), figure_colours::ink);
  if (labels.intervals.size() > most_zooms) {
    const std::size_t more = labels.intervals.size() - most_zooms;
    say(more == 1 ? "1 onset is not shown enlarged." : fmt::format("{} onsets are not shown enlarged.", more),
        figure_colours::ink);
  }
  for (const std::string& remark : script.picture().remarks) say(remark, figure_colours::ink);
  if (labels.flags.empty()) say("Nothing is flagged.", figure_colours::ink);
  for (const labels::LabelFlag& flag : labels.flags) {
    const std::string of = flag.interval_index ? labels.intervals.at(*flag.interval_index).id + ": " : "";
    say((flag.confirmed ? "Flag lifted by a person: " : "Flagged: ") + of + flag.reason,
        flag.confirmed ? figure_colours::faint_ink : label_colours::flag);
  }
  if (lines.size() > most_lines) {
    const std::size_t more = lines.size() - most_lines + 1;
    lines.resize(most_lines - 1);
    lines.push_back({fmt::format("... and {} more lines, as labels.json has them", more), figure_colours::ink});
  }
  return lines;
}

/// The panels one under the other, with the enlarged onsets at their side.
class LabelPanels : public LabelScript {
 public:
  explicit LabelPanels(const LabelPicture& picture) : LabelScript(picture) {}

  Plot plot() && {
    const std::vector<const labels::LabelledInterval*> zooms = onsets_to_enlarge(picture().labels);
    panels_right_ = zooms.empty() ? picture_width - left : panels_right_beside_zooms;
    choose_panels();
    const int height = stretch_panels(static_cast<int>(zooms.size()) * (least_zoom_height + zoom_title + zoom_axis));
    std::vector<TraceKind> kinds;
    for (const Panel& panel : panels_) {
      if (panel.kind) kinds.push_back(*panel.kind);
    }
    const std::vector<LabelNote> notes = label_notes(*this, kinds);
    resize(picture_width, top + height + 16 + static_cast<int>(notes.size()) * line_height + 14);
    add("set multiplot");
    add("set border 3 lc rgb '{}' lw 0.8", figure_colours::faint_ink);
    add("set tics nomirror scale 0.5 textcolor rgb '{}'", figure_colours::ink);
    add("set grid x y lt 1 lc rgb '#E6E6E6' lw 0.6");
    add("set style data lines");
    add("set style textbox opaque noborder margins 0.4,0.2 fillcolor rgb 'white'");
    write(picture().title, left, 28, "font ',14' left", figure_colours::ink);
    for (std::size_t i = 0; i < notes.size(); ++i)
      write(notes[i].words, left - 60, top + height + 30 + static_cast<int>(i) * line_height, "left", notes[i].colour);
    draw_panels();
    const int share = zooms.empty() ? 0 : std::min(tallest_zoom, height / static_cast<int>(zooms.size()));
    for (std::size_t i = 0; i < zooms.size(); ++i) {
      const int zoom_top = top - 20 + static_cast<int>(i) * share;
      draw_zoom(*this, *zooms[i],
                {.left = zoom_left,
                 .top = zoom_top + zoom_title,
                 .right = picture_width - right,
                 .bottom = zoom_top + share - zoom_axis + 20},
                i + 1 == zooms.size());
    }
    return std::move(*this).finished();
  }

 private:
  struct Panel {
    std::optional<TraceKind> kind;  ///< nothing: the events
    int height = 0;
    void (LabelPanels::*draw)(const PlotBox&) = nullptr;
  };

  /// Makes the panels as high as the enlarged onsets need. @return  the height of all [px]
  int stretch_panels(int least_height) {
    int height = axis_height - between_panels;
    for (const Panel& panel : panels_) height += panel.height + between_panels;
    if (least_height <= height) return height;
    // Rows of outputs keep their height.
    const auto grows = [](const Panel& panel) { return panel.kind != TraceKind::stage_output; };
    const auto growing = static_cast<int>(std::count_if(panels_.begin(), panels_.end(), grows));
    for (Panel& panel : panels_) panel.height += grows(panel) ? (least_height - height) / growing : 0;
    return least_height;
  }

  void draw_panels() {
    int y = top;
    for (const Panel& panel : panels_) {
      const PlotBox box{.left = left, .top = y, .right = panels_right_, .bottom = y + panel.height};
      const bool is_last = &panel == &panels_.back();
      begin_panel(box, 0, seconds());
      if (is_last)
        add("set xlabel 'camera time since the first event [s]' textcolor rgb '{}'", figure_colours::ink);
      else
        add("unset xlabel");
      add("set format x '{}'", is_last ? "%g" : "");
      mark_intervals(panel.kind);
      (this->*panel.draw)(box);
      y = box.bottom + between_panels;
    }
  }

  /// Presses and slips over the whole panel, with the evidence of the panel's own source.
  void mark_intervals(std::optional<TraceKind> kind) {
    for (const TouchInterval& release : picture().labels.releases)
      band(shown(release.start), shown(release.end), label_colours::release);
    for (const labels::LabelledInterval& interval : picture().labels.intervals)
      band(shown(interval.start.at), shown(interval.end.at), figure_colours::of_interval(interval.touch).area);
    for (const labels::LabelledInterval& interval : picture().labels.intervals) {
      const figure_colours::IntervalColours colours = figure_colours::of_interval(interval.touch);
      for (const alignment::UncertainTime& edge : {interval.start, interval.end})
        band(std::min(shown(edge.low), shown(edge.at) - pixel()), std::max(shown(edge.high), shown(edge.at) + pixel()),
             colours.border);
      upright(shown(interval.start.at), fmt::format("front lc rgb '{}' lw 1.2", colours.strong));
      const bool has_stage = std::any_of(picture().traces.begin(), picture().traces.end(),
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

  void choose_panels() {
    panels_ = {{std::nullopt, 240, &LabelPanels::draw_events}};
    const std::array<std::tuple<TraceKind, int, void (LabelPanels::*)(const PlotBox&)>, 4> others{
        {{TraceKind::tcp_speed, 170, &LabelPanels::draw_robot},
         {TraceKind::stage_output, 16 + 26 * std::max(1, static_cast<int>(outputs().size())), &LabelPanels::draw_outputs},
         {TraceKind::acceleration, 130, &LabelPanels::draw_imu},
         {TraceKind::video_energy, 130, &LabelPanels::draw_video}}};
    for (const auto& [kind, height, draw] : others) {
      const bool there = !traces_of(kind).empty() || (kind == TraceKind::tcp_speed && !traces_of(TraceKind::tcp_height).empty());
      if (there) panels_.push_back({kind, height, draw});
    }
  }

  std::vector<const Trace*> traces_of(TraceKind kind) const {
    std::vector<const Trace*> traces;
    for (const Trace& trace : picture().traces) {
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
    points = thinned(points, 0, seconds(), static_cast<std::size_t>(panels_right_ - left));
    for (const PlotPoint& point : points) range.include(point.y);
    return points;
  }

  /// An axis that shows the range with some room, and at least `least` of it, so that noise does not fill the panel.
  void set_range(std::string_view axis, ValueRange range, double least) {
    if (range.low > range.high) range = {0, 0};
    const double lacking = std::max(0.0, least - (range.high - range.low)), room = 0.06 * std::max(least, range.high - range.low);
    add("set {}range [{:.9g}:{:.9g}]", axis, range.low - lacking / 2 - room, range.high + lacking / 2 + room);
  }

  void draw_events(const PlotBox& box) {
    const double zero_us = static_cast<double>(between(picture().rate.begin, picture().begin).count());
    const std::vector<PlotPoint> points = root_rate(microseconds(2'000), zero_us, zero_us + 1e6 * seconds(), 1e6, zero_us);
    const double highest = 1.05 * highest_of(points);
    add("set yrange [0:{:.9g}]", highest);
    square_tics(highest);
    add("set ylabel 'events per ms' textcolor rgb '{}'", figure_colours::ink);
    name_intervals_over(box);
    add("plot {} lc rgb '{}' lw 1 notitle", table(thinned(points, 0, seconds(), static_cast<std::size_t>(box.right - box.left))),
        figure_colours::ink);
  }

  /// Names above the panel, in as many rows as keep them apart.
  void name_intervals_over(const PlotBox& box) {
    constexpr double character = 8;
    std::vector<double> row_ends;
    for (const labels::LabelledInterval& interval : picture().labels.intervals) {
      const double width = character * static_cast<double>(characters_in(interval.id));
      const double at = std::min(box.left + shown(interval.start.at) / pixel(), box.right - width);
      const auto free = std::find_if(row_ends.begin(), row_ends.end(), [&](double end) { return end + character < at; });
      const auto row = free - row_ends.begin();
      if (free == row_ends.end()) row_ends.push_back(0);
      row_ends[static_cast<std::size_t>(row)] = at + width;
      if (row < 3)
        write(interval.id, static_cast<int>(at), box.top - 9 - 15 * static_cast<int>(row), "left",
              figure_colours::of_interval(interval.touch).strong);
    }
  }

  void draw_robot(const PlotBox&) {
    std::string curves;
    ValueRange speeds{0, 0}, heights;
    const auto curve = [&](const Trace& trace, ValueRange& range, std::string_view axes, std::string_view colour) {
      curves += fmt::format("{}{} axes {} lc rgb '{}' lw 1.5 notitle", curves.empty() ? "" : ", ", table(points_of(trace, range)),
                            axes, colour);
    };
    for (const Trace* trace : traces_of(TraceKind::tcp_height)) curve(*trace, heights, "x1y2", label_colours::height);
    if (!curves.empty()) {
      add("set y2tics\nset border 11\nset y2label 'TCP height [mm]' offset 0.5,0 textcolor rgb '{}'", label_colours::height);
      set_range("y2", heights, 5);
    }
    for (const Trace* trace : traces_of(TraceKind::tcp_speed)) curve(*trace, speeds, "x1y1", label_colours::robot);
    set_range("y", speeds, 5);
    add("set ylabel 'TCP speed [mm/s]' textcolor rgb '{}'", label_colours::robot);
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

  void draw_outputs(const PlotBox&) {
    const std::vector<std::string> names = outputs();
    std::string curves, tics;
    for (std::size_t i = 0; i < names.size(); ++i) {
      // Each output is scaled to its row.
      ValueRange range;
      std::vector<std::vector<PlotPoint>> pieces;
      for (const Trace* trace : traces_of(TraceKind::stage_output)) {
        if (trace->name == names[i]) pieces.push_back(points_of(*trace, range));
      }
      const double row = static_cast<double>(names.size() - 1 - i);
      // A constant output is low where it is 0, else high.
      const double low = range.high > range.low ? range.low : std::min(0.0, range.low);
      const double span = range.high > low ? range.high - low : 1;
      for (std::vector<PlotPoint>& points : pieces) {
        for (PlotPoint& point : points) point.y = row + 0.15 + 0.7 * (point.y - low) / span;
        curves += fmt::format("{}{} with steps lc rgb '{}' lw 1.5 notitle", curves.empty() ? "" : ", ", table(points),
                              label_colours::robot);
      }
      tics += fmt::format("{}{} {}", i > 0 ? ", " : "", plot_text(short_name(names[i])), row + 0.5);
    }
    add("set yrange [0:{}]\nset ytics ({}) scale 0", names.size(), tics);
    add("plot {}", curves);
    add("set tics scale 0.5");
  }

  /// A name that fits next to the panel.
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

  void draw_imu(const PlotBox&) {
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
    add("set ylabel 'IMU [g]' textcolor rgb '{}'", label_colours::imu);
    add("plot {}", curves);
  }

  void draw_video(const PlotBox&) {
    std::string curves;
    ValueRange range{0, 0};
    for (const Trace* trace : traces_of(TraceKind::video_energy)) {
      curves += fmt::format("{}{} lc rgb '{}' lw 1.2 notitle", curves.empty() ? "" : ", ", table(points_of(*trace, range)),
                            label_colours::video);
    }
    set_range("y", range, 1e-9);
    add("set ylabel 'video energy' textcolor rgb '{}'", label_colours::video);
    add("plot {}", curves);
  }

  int panels_right_ = 0;
  std::vector<Panel> panels_;
};

}  // namespace

Plot label_plot(const LabelPicture& picture) { return LabelPanels(picture).plot(); }

void draw_label_picture(const LabelPicture& picture, const std::filesystem::path& file) { draw(label_plot(picture), file); }

}  // namespace tactile::pictures
