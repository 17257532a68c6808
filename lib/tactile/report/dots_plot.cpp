#include "tactile/report/dots_plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "tactile/core/text_lines.hpp"
#include "tactile/pictures/plot_script.hpp"
#include "tactile/pictures/word_places.hpp"
#include "tactile/report/axis_tics.hpp"
#include "tactile/report/figure_parts.hpp"

namespace tactile::report {
namespace {

using pictures::figure_colours::faint_ink;
using pictures::figure_colours::ink;

constexpr std::size_t most_named = 24;   // of a front
constexpr std::size_t most_others = 42;  // numbered, of those on none
constexpr int left = 76, right = 24, panel_height = 340, below = 72;
constexpr pictures::LineStyle other_mark{.colour = "#606060", .width = 0, .mark = 6, .size = 0.75};
constexpr pictures::LineStyle front_mark{.colour = pictures::figure_colours::best, .width = 1.5, .mark = 7, .size = 1.1};
constexpr pictures::LineStyle usual_mark{.colour = ink, .width = 0, .mark = 12, .size = 2.1};

/// A mark of a key, as it is in the panel.
pictures::LineStyle drawn(pictures::LineStyle mark) {
  mark.width = 1.4;
  return mark;
}

using Position = double (*)(double);

/// The dots with y as positions on an axis of `DotAxes::y_from_zero`.
std::vector<Dot> from_zero(std::vector<Dot> dots) {
  for (Dot& dot : dots) {
    dot.y.value = drawn_from_zero(dot.y.value);
    for (std::optional<double>* bound : {&dot.y.low, &dot.y.high}) {
      if (*bound) *bound = drawn_from_zero(**bound);
    }
  }
  return dots;
}

/// A name in lines of at most `characters`, divided after commas and before brackets.
std::vector<std::string> name_lines(std::string name, std::size_t characters) {
  constexpr char stays = '\x1F';  // in the place of a blank at which no line ends
  for (std::size_t i = 1; i < name.size(); ++i) {
    if (name[i] == ' ' && name[i - 1] != ',' && name[i + 1] != '(') name[i] = stays;
  }
  std::vector<std::string> lines = lines_of(wrapped(name, 0, characters));
  for (std::string& line : lines) {
    std::replace(line.begin(), line.end(), stays, ' ');
    line = pictures::shortened(line, characters);
  }
  return lines;
}

/// Numbered names under a figure, down one column after another. Long names take several lines.
class NameList {
 public:
  static constexpr int row = 19;  // [px]

  /// @param columns     > 0
  /// @param characters  of a line, > 0
  NameList(int columns, std::size_t characters) : columns_(columns), characters_(characters) {}

  void add(std::size_t number, const std::string& name) {
    entries_.push_back({number, name_lines(name, characters_)});
    std::size_t all = 0, before = 0;
    for (const Entry& entry : entries_) all += entry.lines.size();
    // Each column takes its share, the last ones what is left.
    std::size_t column = 0, at = 0;
    rows_ = 0;
    for (Entry& entry : entries_) {
      if (before * static_cast<std::size_t>(columns_) >= all * (column + 1)) ++column, at = 0;
      entry.column = column, entry.row = at;
      at += entry.lines.size(), before += entry.lines.size();
      rows_ = std::max(rows_, at);
    }
  }

  bool empty() const { return entries_.empty(); }
  int height() const { return row * static_cast<int>(rows_); }  ///< [px]

  /// @param top  the middle of the first row [px]
  void write(pictures::PlotScript& script, int top) const {
    constexpr int margin = 24, number_width = 26;
    const double width = (page_width - margin - 10.0) / columns_;
    for (const Entry& entry : entries_) {
      const double x = margin + width * static_cast<double>(entry.column);
      int y = top + row * static_cast<int>(entry.row);
      script.text(fmt::format("{}", entry.number), x, y, "left font ',11'");
      for (const std::string& line : entry.lines) {
        script.text(line, x + number_width, y, "left font ',11'");
        y += row;
      }
    }
  }

 private:
  struct Entry {
    std::size_t number = 0;
    std::vector<std::string> lines;
    std::size_t column = 0, row = 0;
  };
  int columns_;
  std::size_t characters_, rows_ = 0;
  std::vector<Entry> entries_;
};

/// The dots by how they are drawn.
struct DotGroups {
  std::vector<const Dot*> front;     ///< by x
  std::vector<const Dot*> others;    ///< hollow
  std::vector<const Dot*> usual;     ///< of both
  std::vector<const Dot*> numbered;  ///< of the others, the usual one aside
  std::size_t without_number = 0, without_value = 0;

  DotGroups(const std::vector<Dot>& dots, Position position_of) {
    for (const Dot& dot : dots) {
      if (!std::isfinite(position_of(dot.x)) || !std::isfinite(dot.y.value)) {
        ++without_value;
        continue;
      }
      (dot.on_front ? front : others).push_back(&dot);
      if (dot.usual) usual.push_back(&dot);
    }
    std::stable_sort(front.begin(), front.end(), [](const Dot* a, const Dot* b) { return a->x < b->x; });
    std::copy_if(others.begin(), others.end(), std::back_inserter(numbered), [](const Dot* dot) { return !dot->usual; });
    std::stable_partition(numbered.begin(), numbered.end(), [](const Dot* dot) { return dot->is_single_change; });
    without_number = numbered.size() - std::min(numbered.size(), most_others);
    numbered.erase(numbered.end() - static_cast<std::ptrdiff_t>(without_number), numbered.end());
  }

  bool empty() const { return front.empty() && others.empty(); }
  std::size_t named() const { return std::min(front.size(), most_named); }

  /// The marks in a key, and what is not shown.
  pictures::PlotHead head(const std::string& title, const DotAxes& axes) const {
    pictures::PlotHead head(title, page_width);
    const auto has_interval = [](const Dot* dot) { return dot->y.has_interval(); };
    if (!front.empty()) {
      head.key("on the front of " + std::string(axes.front), mark_of(front_mark));
      if (std::any_of(front.begin(), front.end(), has_interval))
        head.key("95 % interval of " + std::string(axes.bars), {.colour = front_mark.colour, .width = front_mark.width});
    }
    if (!numbered.empty()) head.key("other settings", other_mark);
    if (!usual.empty()) head.key("the usual setting", usual_mark);
    std::string note;
    if (named() < front.size()) note += fmt::format(" The first {} of {} on the front are numbered.", named(), front.size());
    if (without_number > 0) note += fmt::format(" Without a number: {} more.", without_number);
    if (without_value > 0) note += fmt::format(" Not shown, without a value: {}.", without_value);
    head.note(note.empty() ? note : note.substr(1));
    return head;
  }
};

/// The panel, with places in pixels of the figure.
struct DotPanel {
  pictures::PlotBox box;
  AxisRange across, up;
  Position position_of;

  double x(const Dot& dot) const { return box.left + across.pixel_at(position_of(dot.x)); }
  double y(double value) const { return box.bottom - up.pixel_at(value); }
  std::pair<double, double> place(const Dot& dot) const { return {x(dot), y(dot.y.value)}; }
};

DotPanel panel_of(const DotGroups& groups, const DotAxes& axes, Position position_of, int top) {
  double least_x = HUGE_VAL, most_x = -HUGE_VAL, least_y = HUGE_VAL, most_y = -HUGE_VAL;
  const auto include = [&](const Dot* dot) {
    const double x = position_of(dot->x);
    least_x = std::min(least_x, x), most_x = std::max(most_x, x);
    least_y = std::min(least_y, dot->y.value), most_y = std::max(most_y, dot->y.value);
    if (dot->on_front && dot->y.has_interval()) least_y = std::min(least_y, *dot->y.low), most_y = std::max(most_y, *dot->y.high);
  };
  std::for_each(groups.front.begin(), groups.front.end(), include);
  std::for_each(groups.others.begin(), groups.others.end(), include);
  if (groups.empty()) least_x = most_x = least_y = most_y = 0;
  // 0 is on the axis, as the value that others are compared with, unless that compresses the rest.
  if (axes.x_from_zero && (least_x < 1.5 || 2 * least_x < most_x)) least_x = 0, most_x = std::max(most_x, std::log10(2));
  const pictures::PlotBox box{.left = left, .top = top, .right = page_width - right, .bottom = top + panel_height};
  AxisRange up = range_around(least_y, most_y, axes.y_from_zero ? std::log10(2) : axes.least_y_span, box.bottom - box.top);
  // Beyond the possible values there is room for half a mark alone.
  const double edge = 0.025 * (up.end - up.begin);
  up.begin = std::max(up.begin, axes.y_begin - edge), up.end = std::min(up.end, axes.y_end + edge);
  return {box, range_around(least_x, most_x, std::log10(2), box.right - box.left), up, position_of};
}

/// Dots whose marks overlap, under one label: "8", "8–13".
struct Crowd {
  std::vector<const Dot*> dots;
  std::size_t first_number = 0;

  std::string label() const {
    return dots.size() == 1 ? fmt::format("{}", first_number)
                            : fmt::format("{}–{}", first_number, first_number + dots.size() - 1);
  }
};

/// Dots in crowds, from left to right.
std::vector<Crowd> crowds_of(std::vector<const Dot*> dots, std::size_t first_number, const DotPanel& panel) {
  constexpr double close = 10;  // [px]
  std::stable_sort(dots.begin(), dots.end(), [&](const Dot* a, const Dot* b) { return panel.place(*a) < panel.place(*b); });
  std::vector<Crowd> crowds;
  for (const Dot* dot : dots) {
    const auto [x, y] = panel.place(*dot);
    const auto crowd = std::find_if(crowds.begin(), crowds.end(), [&, x = x, y = y](const Crowd& one) {
      const auto [other_x, other_y] = panel.place(*one.dots.front());
      return std::hypot(x - other_x, y - other_y) < close;
    });
    if (crowd == crowds.end())
      crowds.push_back({.dots = {dot}});
    else
      crowd->dots.push_back(dot);
  }
  for (Crowd& crowd : crowds) {
    crowd.first_number = first_number;
    first_number += crowd.dots.size();
  }
  return crowds;
}

/// Labels next to the marks.
class DotLabels {
 public:
  DotLabels(pictures::PlotScript& script, const DotPanel& panel) : script_(script), panel_(panel), places_(panel.box) {}

  /// A mark covers its place.
  void take(const Dot& dot) {
    constexpr double half_mark = 6, half_diamond = 13;  // [px]
    const auto [x, y] = panel_.place(dot);
    const double half = dot.usual ? half_diamond : half_mark;
    places_.take(x - half, y - half, x + half, y + half);
    if (dot.on_front && dot.y.has_interval()) places_.take(x - 3, panel_.y(*dot.y.high), x + 3, panel_.y(*dot.y.low));
  }

  /// Nothing is written where it would cover other words: the list has the name.
  void write(const std::string& words, const Dot& dot, double character, std::string_view colour) {
    const auto [x, y] = panel_.place(dot);
    const pictures::WordPlaces::Place place = places_.near(x, y, character * static_cast<double>(characters_in(words)));
    if (place.covers_words) return;
    places_.take(place);
    script_.text(words, place.x, place.y, "center font ',11'", colour);
    if (place.is_beside) return;
    const double end_x = std::clamp(x, place.x - place.width / 2, place.x + place.width / 2);
    const double end_y = std::clamp(y, place.y - 7, place.y + 7);
    places_.take_line(x, y, end_x, end_y);
    script_.line(x, y, end_x, end_y, faint_ink, 0.8);
  }

 private:
  pictures::PlotScript& script_;
  const DotPanel& panel_;
  pictures::WordPlaces places_;
};

void draw_panel(pictures::PlotScript& script, const DotPanel& panel, const DotGroups& groups, const std::vector<Crowd>& crowds,
                const DotAxes& axes) {
  constexpr double number_character = 9.5, word_character = 8.4;  // [px]
  script.begin_panel(panel.box);
  script.axes({.begin = panel.across.begin,
               .end = panel.across.end,
               .label = axes.x_label,
               .tics = decade_tics(panel.across, axes.x_from_zero).text()},
              {.begin = panel.up.begin,
               .end = panel.up.end,
               .label = axes.y_label,
               .tics = axes.y_from_zero ? decade_tics(panel.up, true, true).text() : ""});
  DotLabels labels(script, panel);
  std::vector<double> others, front, usual;
  for (const Dot* dot : groups.others) {
    others.insert(others.end(), {panel.position_of(dot->x), dot->y.value});
    labels.take(*dot);
  }
  for (const Dot* dot : groups.front) {
    const results::Figure& y = dot->y;
    front.insert(front.end(),
                 {panel.position_of(dot->x), y.value, y.has_interval() ? *y.low : y.value, y.has_interval() ? *y.high : y.value});
    labels.take(*dot);
  }
  for (const Dot* dot : groups.usual) usual.insert(usual.end(), {panel.position_of(dot->x), dot->y.value});
  for (std::size_t i = 0; i < groups.named(); ++i)
    labels.write(fmt::format("{}", i + 1), *groups.front[i], number_character, ink);
  for (const Dot* dot : groups.usual) labels.write("usual", *dot, word_character, ink);
  for (const Crowd& crowd : crowds) labels.write(crowd.label(), *crowd.dots.front(), number_character, faint_ink);
  if (groups.empty()) {
    const pictures::PlotBox& box = panel.box;
    script.text("nothing to show", (box.left + box.right) / 2.0, (box.top + box.bottom) / 2.0, "center font ',12'", faint_ink);
  }
  script.plot({{script.table(2, std::move(others)), "1:2", "points", drawn(other_mark)},
               {script.table(4, std::move(front)), "1:2:3:4", "yerrorbars", front_mark},
               {script.table(2, std::move(usual)), "1:2", "points", drawn(usual_mark)}});
}

}  // namespace

pictures::Plot dots_plot(const std::string& title, const DotAxes& axes, const std::vector<Dot>& dots) {
  const Position position_of = axes.x_from_zero ? log_position_from_zero : log_position;
  const std::vector<Dot> placed = axes.y_from_zero ? from_zero(dots) : dots;
  const DotGroups groups(placed, position_of);
  const pictures::PlotHead head = groups.head(title, axes);
  const DotPanel panel = panel_of(groups, axes, position_of, head.bottom() + 16);

  NameList front_names(1, 60), other_names(2, 31);
  for (std::size_t i = 0; i < groups.named(); ++i) front_names.add(i + 1, groups.front[i]->text);
  const std::vector<Crowd> crowds = crowds_of(groups.numbered, groups.named() + 1, panel);
  for (const Crowd& crowd : crowds) {
    for (std::size_t i = 0; i < crowd.dots.size(); ++i) other_names.add(crowd.first_number + i, crowd.dots[i]->text);
  }
  int height = panel.box.bottom + below;
  const auto room_for = [&height](const NameList& names) {
    const int begin = height;
    if (!names.empty()) height += NameList::row + names.height();
    return begin;
  };
  const int front_top = room_for(front_names), others_top = room_for(other_names) + (front_names.empty() ? 0 : 8);
  height += front_names.empty() || other_names.empty() ? 6 : 14;

  pictures::PlotScript script(head, height);
  const auto write = [&script](const NameList& names, const char* heading, int top) {
    if (!names.empty()) script.text(heading, 24, top, "left font ',11'", faint_ink);
  };
  write(front_names, "The front, by difference from the usual setting:", front_top - 2);
  front_names.write(script, front_top + NameList::row);
  write(other_names, front_names.empty() ? "By difference from the usual setting:" : "The others:", others_top - 2);
  other_names.write(script, others_top + NameList::row);
  draw_panel(script, panel, groups, crowds, axes);
  return std::move(script).finished();
}

}  // namespace tactile::report
