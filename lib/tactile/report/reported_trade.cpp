#include "tactile/report/reported_trade.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/report/plot_script.hpp"
#include "tactile/report/word_places.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile {
namespace {

using figure_colours::faint_ink;
using figure_colours::ink;

constexpr int page_width = 1000;         // [px]
constexpr std::size_t most_named = 24;   // of a front
constexpr std::size_t most_others = 42;  // numbered, of those on none

ReportedSetting setting_in(const JsonView& json) {
  const JsonView reported = json["reported"], difference = json["difference"];
  return {.text = json["text"].text(),
          .design = json["design"].text(),
          .seeds = json["seeds"].count(),
          .accuracy = reported["accuracy"].get<Figure>(),
          .us_p50 = reported["us"]["p50"].get<Figure>(),
          .us_p99 = reported["us"]["p99"].get<Figure>(),
          .delay_us = reported["delay_us"]["mean"].get<Figure>(),
          .delay_p95_us = reported["delay_us"]["p95"].get<Figure>(),
          .missed = reported["delay_us"]["missed"].get<Figure>(),
          .false_alarms_per_min = reported["false_alarms_per_min"].get<Figure>(),
          .accuracy_difference = difference ? difference["accuracy"].get<Figure>() : Figure{},
          .delay_difference_us = difference ? difference["delay_us"].get<Figure>() : Figure{},
          .false_alarms_difference = difference ? difference["false_alarms_per_min"].get<Figure>() : Figure{},
          .on_accuracy_front = json["front"]["accuracy"].truth(),
          .on_delay_front = json["front"]["delay"].truth()};
}

/// A value's place on an axis of logarithms, and on one that is linear near 0 and logarithmic beyond.
double log_place(double value) { return value > 0 ? std::log10(value) : NAN; }
double log_place_from_zero(double value) { return value >= 0 ? std::log10(value + 1) : NAN; }

/// Places [begin, end] of an axis, and how many pixels they take.
struct Stretch {
  double begin = 0, end = 1;
  double pixels = 1;
  double at(double place) const { return pixels * (place - begin) / (end - begin); }
  bool holds(double place) const { return place >= begin && place <= end; }
};

/// Holds [least, most], is `shortest` long at least, and has a margin on both sides.
Stretch stretch_around(double least, double most, double shortest, double pixels) {
  if (!(least <= most)) least = most = 0;  // nothing is there
  const double wanting = std::max(0.0, shortest - (most - least)) / 2;
  least -= wanting, most += wanting;
  const double margin = 0.05 * (most - least);
  return {least - margin, most + margin, pixels};
}

/// Tics of an axis whose labels do not meet.
class Tics {
 public:
  static constexpr double character = 9.4, gap = 8;  // [px], of a digit and between labels
  static constexpr double line = 20;                 // [px], of labels one above the other

  /// @param is_upright  labels stand above each other
  explicit Tics(const Stretch& stretch, bool is_upright = false) : stretch_(stretch), is_upright_(is_upright) {}

  /// All of them; none where they lie off the axis, or where their labels would meet each other or those there.
  bool add(const std::vector<std::pair<double, std::string>>& tics) {
    const std::size_t before = tics_.size();
    for (const auto& [place, label] : tics) {
      if (!stretch_.holds(place)) continue;
      const double at = stretch_.at(place);
      const double room = is_upright_ ? line : character * static_cast<double>(characters_in(label)) + gap;
      if (std::any_of(tics_.begin(), tics_.end(),
                      [&](const Tic& other) { return std::abs(other.at - at) < (other.room + room) / 2; })) {
        tics_.resize(before);
        return false;
      }
      tics_.push_back({place, at, room, label});
    }
    return true;
  }

  /// A tic without a label.
  void add_bare(double place) { bare_ += fmt::format(", '' {:.9g}", place); }

  std::size_t size() const { return tics_.size(); }

  /// As gnuplot takes them.
  std::string text(bool with_labels = true) const {
    std::string text;
    for (const Tic& tic : tics_) text += fmt::format(", {} {:.9g}", with_labels ? plot_text(tic.label) : "''", tic.place);
    text += bare_;
    return text.empty() ? "'' 0" : text.substr(2);
  }

 private:
  struct Tic {
    double place, at, room;
    std::string label;
  };
  Stretch stretch_;
  bool is_upright_;
  std::vector<Tic> tics_;
  std::string bare_;
};

/// Round values of an axis of logarithms, as many as fit: 1, 2 and 5 of each decade, finer ones where these are few; from 0 on
/// 0 and 1 and 3 of each decade.
Tics decade_tics(const Stretch& stretch, double (*place_of)(double), bool from_zero, bool is_upright = false) {
  constexpr std::size_t few = 4;
  constexpr int least_decade = -9, most_decade = 12;
  Tics tics(stretch, is_upright);
  const auto of_each = [&](const std::vector<double>& steps, int first, int every) {
    std::vector<std::pair<double, std::string>> values;
    for (int decade = first; decade <= most_decade; decade += every) {
      for (const double step : steps) {
        const double value = step * std::pow(10, decade);
        values.emplace_back(place_of(value), fmt::format("{:.10g}", value));
      }
    }
    return values;
  };
  for (int every = 1; every <= 8; ++every) {
    // Counted from 1, so that every second one is 1, 100, 10000.
    auto decades = of_each({1}, from_zero ? 0 : -every * (-least_decade / every), every);
    if (from_zero) decades.emplace_back(place_of(0), "0");
    if (tics.add(decades)) break;
  }
  const int first = from_zero ? 0 : least_decade;
  tics.add(of_each(from_zero ? std::vector<double>{3} : std::vector<double>{2, 5}, first, 1));
  const int first_fine = from_zero ? -1 : least_decade;
  for (const auto& steps : from_zero ? std::vector<std::vector<double>>{{5}, {2}, {4, 7}, {1.2, 1.5, 2.5, 6, 8}}
                                     : std::vector<std::vector<double>>{{1.5, 3, 7}, {1.2, 2.5, 4, 6, 8}}) {
    if (tics.size() < few) tics.add(of_each(steps, first_fine, 1));
  }
  return tics;
}

/// A setting's name in lines that each fit a column, broken between its knobs.
std::vector<std::string> name_lines(std::string name, std::size_t characters) {
  constexpr char stays = '\x1F';  // for a blank within a knob, while lines are broken
  for (std::size_t i = 1; i < name.size(); ++i) {
    if (name[i] == ' ' && name[i - 1] != ',') name[i] = stays;
  }
  std::vector<std::string> lines = lines_of(wrapped(name, 0, characters));
  for (std::string& line : lines) {
    std::replace(line.begin(), line.end(), stays, ' ');
    line = shortened(line, characters);
  }
  return lines;
}

/// Names with their numbers, down one column after another.
class NameList {
 public:
  static constexpr int row = 19;  // [px]

  NameList(int columns, std::size_t characters) : columns_(columns), characters_(characters) {}

  void add(std::size_t number, const std::string& name) {
    entries_.push_back({number, name_lines(name, characters_), 0, 0});
    std::size_t all = 0, before = 0;
    for (const Entry& entry : entries_) all += entry.lines.size();
    // Each column takes its share, the last ones what is left.
    std::size_t column = 0, at = 0;
    rows_ = 0;
    for (Entry& entry : entries_) {
      if (before * static_cast<std::size_t>(columns_) >= all * (column + 1)) ++column, at = 0;
      entry.column = column, entry.at = at;
      at += entry.lines.size(), before += entry.lines.size();
      rows_ = std::max(rows_, at);
    }
  }

  bool empty() const { return entries_.empty(); }
  int height() const { return row * static_cast<int>(rows_); }

  /// @param top  the middle of the first row [px]
  void write(PlotScript& script, int top) const {
    constexpr int left = 24, number_width = 26;
    const double width = (page_width - left - 10.0) / columns_;
    for (const Entry& entry : entries_) {
      const double x = left + width * static_cast<double>(entry.column);
      int y = top + row * static_cast<int>(entry.at);
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
    std::size_t column = 0, at = 0;  ///< rows down
  };
  int columns_;
  std::size_t characters_, rows_ = 0;
  std::vector<Entry> entries_;
};

/// A setting's place in a figure.
struct Dot {
  double x = NAN;
  Figure y;
  bool on_front = false, usual = false;
  bool is_one_knob = false;  ///< one alone differs from the usual setting
  std::string text;

  bool has_place() const { return std::isfinite(x) && std::isfinite(y.value); }
};

struct Axes {
  std::string front;  ///< what is on it, in words
  std::string bars;   ///< what they are intervals of
  std::string x_label, y_label;
  bool x_from_zero = false;              ///< linear near 0, logarithmic beyond; else all of it logarithmic
  double least_y_span = 1;               ///< a shorter axis would show differences that mean nothing
  double y_begin = 0, y_end = INFINITY;  ///< no value lies outside
};

/// Dots whose marks meet, under one label: "8", "8–13".
struct Crowd {
  std::vector<const Dot*> dots;
  std::size_t first_number = 0;

  std::string label() const {
    return dots.size() == 1 ? fmt::format("{}", first_number)
                            : fmt::format("{}–{}", first_number, first_number + dots.size() - 1);
  }
};

/// Dots in crowds, from left to right. @param place  a dot's, in pixels
template <class PlaceOf>
std::vector<Crowd> crowds_of(std::vector<const Dot*> dots, std::size_t first_number, PlaceOf place) {
  constexpr double close = 10;  // [px]
  std::stable_sort(dots.begin(), dots.end(), [&](const Dot* a, const Dot* b) { return place(*a) < place(*b); });
  std::vector<Crowd> crowds;
  for (const Dot* dot : dots) {
    const auto [x, y] = place(*dot);
    const auto crowd = std::find_if(crowds.begin(), crowds.end(), [&, x = x, y = y](const Crowd& one) {
      const auto [other_x, other_y] = place(*one.dots.front());
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

Plot dots_plot(const std::string& title, const Axes& axes, const std::vector<Dot>& dots) {
  constexpr int left = 90, right = 40, panel_height = 420, below = 72, row = NameList::row, note_row = 20, note_top = 52;
  constexpr std::size_t note_characters = 114;
  constexpr double half_mark = 6, half_diamond = 13, number_character = 9.5, word_character = 8.4;  // [px]
  const auto place_of = axes.x_from_zero ? log_place_from_zero : log_place;

  std::vector<const Dot*> front, others, usual;
  std::size_t left_out = 0;
  double least_x = INFINITY, most_x = -INFINITY, least_y = INFINITY, most_y = -INFINITY;
  bool has_bars = false;
  for (const Dot& dot : dots) {
    const double x = place_of(dot.x);
    if (!dot.has_place() || !std::isfinite(x)) {
      ++left_out;
      continue;
    }
    (dot.on_front ? front : others).push_back(&dot);
    if (dot.usual) usual.push_back(&dot);
    least_x = std::min(least_x, x), most_x = std::max(most_x, x);
    least_y = std::min(least_y, dot.y.value), most_y = std::max(most_y, dot.y.value);
    if (dot.on_front && dot.y.has_interval()) {
      has_bars = true;
      least_y = std::min(least_y, *dot.y.low), most_y = std::max(most_y, *dot.y.high);
    }
  }
  std::stable_sort(front.begin(), front.end(), [](const Dot* a, const Dot* b) { return a->x < b->x; });
  const std::size_t named = std::min(front.size(), most_named);
  // The usual one has a word of its own. Where there are too many, those that differ by one knob come first.
  std::vector<const Dot*> numbered;
  std::copy_if(others.begin(), others.end(), std::back_inserter(numbered), [](const Dot* dot) { return !dot->usual; });
  std::stable_partition(numbered.begin(), numbered.end(), [](const Dot* dot) { return dot->is_one_knob; });
  const std::size_t without_number = numbered.size() - std::min(numbered.size(), most_others);
  numbered.erase(numbered.end() - static_cast<std::ptrdiff_t>(without_number), numbered.end());

  std::string note = "Each circle is a setting, on the reported runs";
  note += !usual.empty() ? "; the usual one is in a diamond." : ".";
  if (!front.empty()) {
    note += fmt::format(
        " Filled{}: the front, {}, as found on the runs to choose on.",
        named < front.size() ? fmt::format(", and the first {} of {} numbered", named, front.size()) : " and numbered",
        axes.front);
  }
  if (has_bars) note += fmt::format(" Bars: 95 % intervals of {}.", axes.bars);
  if (!numbered.empty()) note += " Hollow: the others; a range of numbers is of circles that meet.";
  if (without_number > 0) note += fmt::format(" Without a number: {} more.", without_number);
  if (left_out > 0) note += fmt::format(" Left out for want of a value: {}.", left_out);
  const std::vector<std::string> note_lines = lines_of(wrapped(note, 0, note_characters));
  const int top = note_top + note_row * static_cast<int>(note_lines.size()) + 4, bottom = top + panel_height;

  const PlotBox box{.left = left, .top = top, .right = page_width - right, .bottom = bottom};
  if (front.empty() && others.empty()) least_x = most_x = least_y = most_y = 0;
  // No false alarms at all is what others are compared with, unless that makes what is there small.
  if (axes.x_from_zero && (least_x < 1.5 || 2 * least_x < most_x)) least_x = 0, most_x = std::max(most_x, std::log10(2));
  const Stretch across = stretch_around(least_x, most_x, std::log10(2), box.right - box.left);
  Stretch up = stretch_around(least_y, most_y, axes.least_y_span, box.bottom - box.top);
  // Beyond what can be there is nothing but room for half a mark.
  const double edge = 0.025 * (up.end - up.begin);
  up.begin = std::max(up.begin, axes.y_begin - edge), up.end = std::min(up.end, axes.y_end + edge);
  const auto at_x = [&](const Dot& dot) { return box.left + across.at(place_of(dot.x)); };
  const auto at_y = [&](double y) { return box.bottom - up.at(y); };
  const auto at = [&](const Dot& dot) { return std::pair(at_x(dot), at_y(dot.y.value)); };

  NameList front_names(2, 60), other_names(3, 38);
  for (std::size_t i = 0; i < named; ++i) front_names.add(i + 1, front[i]->text);
  const std::vector<Crowd> crowds = crowds_of(std::move(numbered), named + 1, at);
  for (const Crowd& crowd : crowds) {
    for (std::size_t i = 0; i < crowd.dots.size(); ++i) other_names.add(crowd.first_number + i, crowd.dots[i]->text);
  }
  int height = bottom + below;
  const auto room_for = [&height](const NameList& names) {
    const int begin = height;
    if (!names.empty()) height += row + names.height();
    return begin;
  };
  const int front_top = room_for(front_names), others_top = room_for(other_names) + (front_names.empty() ? 0 : 8);
  height += front_names.empty() || other_names.empty() ? 6 : 14;

  PlotScript script(title, page_width, height);
  for (std::size_t i = 0; i < note_lines.size(); ++i)
    script.text(note_lines[i], 20, note_top + note_row * static_cast<int>(i), "left font ',12'", faint_ink);
  if (!front_names.empty())
    script.text("The front, each by what is other than usual:", 24, front_top - 2, "left font ',11'", faint_ink);
  front_names.write(script, front_top + row);
  if (!other_names.empty()) {
    script.text(front_names.empty() ? "Each by what is other than usual:" : "The others:", 24, others_top - 2, "left font ',11'",
                faint_ink);
  }
  other_names.write(script, others_top + row);

  script.begin_panel(box);
  script.add("set xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]", across.begin, across.end, up.begin, up.end);
  script.add("set xtics ({})", decade_tics(across, place_of, axes.x_from_zero).text());
  script.add("set xlabel {} textcolor rgb '{}'\nset ylabel {} textcolor rgb '{}'", plot_text(axes.x_label), ink,
             plot_text(axes.y_label), ink);

  std::vector<double> other_values, front_values, usual_values;
  WordPlaces places(box);
  const auto take = [&](const Dot& dot) {
    const auto [x, y] = at(dot);
    const double half = dot.usual ? half_diamond : half_mark;
    places.take(x - half, y - half, x + half, y + half);
    if (dot.on_front && dot.y.has_interval()) places.take(x - 3, at_y(*dot.y.high), x + 3, at_y(*dot.y.low));
    if (dot.usual) usual_values.insert(usual_values.end(), {place_of(dot.x), dot.y.value});
  };
  for (const Dot* dot : others) {
    other_values.insert(other_values.end(), {place_of(dot->x), dot->y.value});
    take(*dot);
  }
  for (const Dot* dot : front) {
    front_values.insert(front_values.end(), {place_of(dot->x), dot->y.value, dot->y.has_interval() ? *dot->y.low : dot->y.value,
                                             dot->y.has_interval() ? *dot->y.high : dot->y.value});
    take(*dot);
  }
  const auto write_at = [&](const std::string& words, const Dot& dot, double character, std::string_view colour) {
    const auto [x, y] = at(dot);
    const WordPlaces::Place place = places.near(x, y, character * static_cast<double>(characters_in(words)));
    if (place.covers_words) return;  // neither could be read; the list has it
    places.take(place);
    script.text(words, place.x, place.y, "center font ',11'", colour);
    if (place.is_beside) return;
    const double end_x = std::clamp(x, place.x - place.width / 2, place.x + place.width / 2);
    const double end_y = std::clamp(y, place.y - 7, place.y + 7);
    places.take_line(x, y, end_x, end_y);
    script.add("set arrow from screen {:.6f}, screen {:.6f} to screen {:.6f}, screen {:.6f} nohead lc rgb '{}' lw 0.8",
               x / page_width, 1 - y / height, end_x / page_width, 1 - end_y / height, faint_ink);
  };
  for (std::size_t i = 0; i < named; ++i) write_at(fmt::format("{}", i + 1), *front[i], number_character, ink);
  for (const Dot* dot : usual) write_at("usual", *dot, word_character, ink);
  for (const Crowd& crowd : crowds) write_at(crowd.label(), *crowd.dots.front(), number_character, faint_ink);
  if (front.empty() && others.empty())
    script.text("nothing to show", (box.left + box.right) / 2.0, (box.top + box.bottom) / 2.0, "center font ',12'", faint_ink);
  const std::string front_table = script.table(4, std::move(front_values));
  script.add(
      "plot {0} using 1:2 with points lc rgb '{1}' pt 6 ps 0.75 lw 1.1 notitle, "
      "{2} using 1:2:3:4 with yerrorbars lc rgb '{3}' lw 1.5 pt 7 ps 1.1 notitle, "
      "{4} using 1:2 with points lc rgb '{5}' pt 12 ps 2.1 lw 1.5 notitle",
      script.table(2, std::move(other_values)), "#606060", front_table, figure_colours::best,
      script.table(2, std::move(usual_values)), ink);
  return std::move(script).plot();
}

/// 300k for 300'000, 10M for ten million.
std::string short_number(double value) {
  if (value >= 1e6) return fmt::format("{:g}M", value / 1e6);
  return value >= 1e4 ? fmt::format("{:g}k", value / 1e3) : fmt::format("{:g}", value);
}

std::string with_runs(const ReportedTrade& trade, const std::string& words) {
  return trade.simulated ? words + " (simulated runs)" : words;
}

}  // namespace

ReportedTrade read_trade(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "trade.json";
  const auto document = nlohmann::json::parse(read_text(file), nullptr, false);
  if (document.is_discarded()) throw Error(file.string() + ": no JSON; expected what 'tactile trade' wrote");
  const JsonView json(document, file.string());
  if (json["format"].text() != "tactile-trade-1")
    throw Error(file.string() + ": another format; expected tactile-trade-1, as 'tactile trade' writes it");
  ReportedTrade trade{.title = json["title"].text(),
                      .times_are = json["times_are"].text(),
                      .machine = json["machine"]["cpu"].text(),
                      .simulated = json["simulated"].truth(),
                      .choice_runs = json["runs"]["choice"].texts(),
                      .reported_runs = json["runs"]["reported"].texts(),
                      .settings = {},
                      .left_out = {},
                      .growth = json["growth"].get<CostGrowth>(),
                      .sentence = json["recommendation"]["sentence"].text()};
  for (const JsonView& point : json["points"].items()) trade.settings.push_back(setting_in(point));
  for (const JsonView& pair : json["left_out"].items()) {
    trade.left_out.push_back(fmt::format("t_h {:g} ms with a tick of {:g} ms: {}", pair["th_ms"].number(),
                                         pair["tick_ms"].number(), pair["why"].text()));
  }
  for (const JsonView& one : json["not_measured"].items())
    trade.left_out.push_back(fmt::format("{}: {}", one["setting"].text(), one["why"].text()));
  if (const JsonView unfinished = json["unfinished"]) trade.left_out.push_back(unfinished.text());
  return trade;
}

Plot trade_accuracy_plot(const ReportedTrade& trade) {
  std::vector<Dot> dots;
  for (const ReportedSetting& setting : trade.settings) {
    dots.push_back({.x = setting.us_p99.value,
                    .y = scaled(setting.accuracy, 100),
                    .on_front = setting.on_accuracy_front,
                    .usual = setting.design == "usual",
                    .is_one_knob = setting.text.find(',') == std::string::npos,
                    .text = setting.text});
  }
  return dots_plot(with_runs(trade, "Accuracy against time per tick"),
                   {.front = "which no other setting beats in both",
                    .bars = "accuracy",
                    .x_label = "time that 99 of 100 ticks do not exceed [us]",
                    .y_label = "accuracy [%]",
                    .least_y_span = 4,
                    .y_end = 100},
                   dots);
}

Plot trade_delay_plot(const ReportedTrade& trade) {
  std::vector<Dot> dots;
  for (const ReportedSetting& setting : trade.settings) {
    dots.push_back({.x = setting.false_alarms_per_min.value,
                    .y = scaled(setting.delay_us, 1e-3),
                    .on_front = setting.on_delay_front,
                    .usual = setting.design == "usual",
                    .is_one_knob = setting.text.find(',') == std::string::npos,
                    .text = std::isfinite(setting.missed.value)
                                ? fmt::format("{} ({:.1f} % missed)", setting.text, 100 * setting.missed.value)
                                : setting.text});
  }
  return dots_plot(with_runs(trade, "Detection delay against false alarms"),
                   {.front = "which no other setting beats in false alarms, delay and misses together",
                    .bars = "the delay",
                    .x_label = "false alarms per minute",
                    .y_label = "mean delay [ms]",
                    .x_from_zero = true,
                    .least_y_span = 2},
                   dots);
}

Plot trade_growth_plot(const ReportedTrade& trade) {
  constexpr int left = 70, right = 20, top = 122, gap = 28, panel_height = 330, below = 124;
  constexpr std::array<int, 3> widths{384, 200, 270};  // those with more to be labelled are wider
  static_assert(left + widths[0] + widths[1] + widths[2] + 2 * gap + right == page_width);
  constexpr int bottom = top + panel_height;
  PlotScript script(with_runs(trade, "How the cost of a tick grows"), page_width, bottom + below);
  script.text(
      "Blue circles: ours, all of a tick; hollow and dashed: its rendering alone. Orange squares, likewise: the dense way,", 20,
      52, "left font ',12'", faint_ink);
  script.text("which computes every pixel and every output of the network.", 20, 72, "left font ',12'", faint_ink);
  script.text("median time per tick [us]", 20, 100, "left font ',12'");
  double most = -INFINITY, least = INFINITY;
  const auto& [by_rate, by_history, by_resolution] = trade.growth;
  const auto times_of = [](const GrowthPoint& point) {
    return std::array{point.sparse.p50_us, point.sparse.rendering_us, point.dense.p50_us, point.dense.rendering_us};
  };
  for (const auto* curve : {&by_rate, &by_history, &by_resolution}) {
    for (const GrowthPoint& point : *curve) {
      for (const double us : times_of(point)) {
        const double place = log_place(us);
        if (std::isfinite(place)) most = std::max(most, place), least = std::min(least, place);
      }
    }
  }
  const Stretch up = stretch_around(least, most, 1, panel_height);
  const Tics us_tics = decade_tics(up, log_place, false, true);

  /// A place along a panel, and how it is called; where it is not finite the point is left out.
  struct Labelled {
    double place = NAN;
    std::string label;
  };
  int begin = left, column = 0;
  const auto panel = [&](const std::vector<GrowthPoint>& points, const std::string& label, const std::string& conditions,
                         auto step_of) {
    const int width = widths[static_cast<std::size_t>(column)];
    const PlotBox box{.left = begin, .top = top, .right = begin + width, .bottom = bottom};
    script.begin_panel(box);
    const double middle = (box.left + box.right) / 2.0;
    script.text(label, middle, bottom + 84, "center font ',12'");
    script.text(conditions, middle, bottom + 105, "center font ',11'", faint_ink);
    std::vector<Labelled> steps;
    std::vector<double> values;
    double first = INFINITY, last = -INFINITY;
    for (const GrowthPoint& point : points) {
      const Labelled step = step_of(point);
      if (!std::isfinite(step.place)) continue;
      first = std::min(first, step.place), last = std::max(last, step.place);
      steps.push_back(step);
      values.push_back(step.place);
      for (const double us : times_of(point)) values.push_back(log_place(us));
      // No line leads from none at all to some: on an axis of logarithms the way between them is of any length.
      if (point.events_per_s <= 0) values.insert(values.end(), 5, NAN);
    }
    const Stretch across = stretch_around(first, last, std::log10(4), width);
    Tics level(across), aslant(across, true);
    bool all_fit = true;
    for (const Labelled& step : steps) {
      // Nor may they reach into the panel beside it.
      const double at = across.at(step.place), half = Tics::character * static_cast<double>(characters_in(step.label)) / 2;
      all_fit = level.add({{step.place, step.label}}) && at >= half - gap / 2.0 && at + half <= width + gap / 2.0 && all_fit;
    }
    for (const Labelled& step : steps) {
      if (!aslant.add({{step.place, step.label}})) aslant.add_bare(step.place);
    }
    script.add("set xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]", across.begin, across.end, up.begin, up.end);
    script.add("set xtics {} ({})\nset ytics ({})", all_fit ? "center" : "rotate by 45 right", (all_fit ? level : aslant).text(),
               us_tics.text(column == 0));
    if (steps.empty()) script.text("not measured", middle, (top + bottom) / 2.0, "center font ',12'", faint_ink);
    script.add(
        "plot {0} using 1:2 with linespoints lc rgb '{1}' lw 1.8 pt 7 ps 0.8 notitle, "
        "{0} using 1:3 with linespoints lc rgb '{1}' lw 1.4 dt 2 pt 6 ps 0.8 notitle, "
        "{0} using 1:4 with linespoints lc rgb '{2}' lw 1.8 pt 5 ps 0.8 notitle, "
        "{0} using 1:5 with linespoints lc rgb '{2}' lw 1.4 dt 2 pt 4 ps 0.8 notitle",
        script.table(5, std::move(values)), figure_colours::network, figure_colours::best);
    begin += width + gap, ++column;
  };
  // None at all has its place left of the least rate.
  double least_rate = INFINITY;
  for (const GrowthPoint& point : by_rate) {
    if (point.events_per_s > 0) least_rate = std::min(least_rate, point.events_per_s);
  }
  const double none_at = std::isfinite(least_rate) ? log_place(least_rate) - 0.6 : 0;
  const auto in_ms = [](const GrowthPoint& point) { return static_cast<double>(point.history.count()) / 1000; };
  const auto history_of = [in_ms](const GrowthPoint& point) { return fmt::format("t_h {:g} ms", in_ms(point)); };
  const auto rate_of = [](const GrowthPoint& point) { return short_number(point.events_per_s) + " events/s"; };
  const auto sensor_of = [](const GrowthPoint& point) { return fmt::format("{}x{}", point.sensor.width, point.sensor.height); };
  panel(by_rate, "events per second", by_rate.empty() ? "" : history_of(by_rate.front()) + ", " + sensor_of(by_rate.front()),
        [&](const GrowthPoint& point) {
          return Labelled{point.events_per_s == 0 ? none_at : log_place(point.events_per_s), short_number(point.events_per_s)};
        });
  panel(by_history, "history t_h [ms]",
        by_history.empty() ? "" : rate_of(by_history.front()) + ", " + sensor_of(by_history.front()),
        [&](const GrowthPoint& point) {
          return Labelled{log_place(in_ms(point)), fmt::format("{:g}", in_ms(point))};
        });
  panel(by_resolution, "pixels of the sensor",
        by_resolution.empty() ? "" : history_of(by_resolution.front()) + ", " + rate_of(by_resolution.front()),
        [&](const GrowthPoint& point) {
          return Labelled{log_place(static_cast<double>(point.sensor.width) * point.sensor.height), sensor_of(point)};
        });
  return std::move(script).plot();
}

}  // namespace tactile
