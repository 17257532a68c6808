#include "tactile/report/reported_trade.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/report/json_view.hpp"
#include "tactile/report/plot_script.hpp"

namespace tactile {
namespace {

using figure_colours::faint_ink;
using figure_colours::ink;

constexpr int page_width = 1000;        // [px]
constexpr std::size_t most_named = 24;  // of a front

ReportedSetting setting_in(const JsonView& json) {
  const JsonView reported = json["reported"], difference = json["difference"];
  return {.text = json["text"].text(),
          .design = json["design"].text(),
          .seeds = json["seeds"].count(),
          .accuracy = reported["accuracy"].measured(),
          .us_p50 = reported["us"]["p50"].measured(),
          .us_p99 = reported["us"]["p99"].measured(),
          .delay_us = reported["delay_us"]["mean"].measured(),
          .delay_p95_us = reported["delay_us"]["p95"].measured(),
          .missed = reported["delay_us"]["missed"].measured(),
          .false_alarms_per_min = reported["false_alarms_per_min"].measured(),
          .accuracy_difference = difference ? difference["accuracy"].measured() : Measured{},
          .delay_difference_us = difference ? difference["delay_us"].measured() : Measured{},
          .false_alarms_difference = difference ? difference["false_alarms_per_min"].measured() : Measured{},
          .on_accuracy_front = json["front"]["accuracy"].truth(),
          .on_delay_front = json["front"]["delay"].truth()};
}

std::vector<ReportedGrowth> growth_in(const JsonView& json) {
  std::vector<ReportedGrowth> points;
  for (const JsonView& point : json.items()) {
    const auto sensor = point["sensor"].items();
    points.push_back({.events_per_s = point["events_per_s"].number(),
                      .history_ms = point["th_ms"].number(),
                      .width = sensor.size() == 2 ? sensor[0].number() : NAN,
                      .height = sensor.size() == 2 ? sensor[1].number() : NAN,
                      .sparse_us = point["sparse"]["p50_us"].number(),
                      .sparse_rendering_us = point["sparse"]["rendering_us"].number(),
                      .dense_us = point["dense"]["p50_us"].number(),
                      .dense_rendering_us = point["dense"]["rendering_us"].number()});
  }
  return points;
}

/// A setting's place in a figure.
struct Dot {
  double x = NAN;
  Measured y;
  bool on_front = false, usual = false;
  std::string text;
};

struct Axes {
  std::string note, x_label, y_label;
  bool log_x = false;
  double top = NAN;  ///< the y axis ends there, where it is given
};

Plot dots_plot(const std::string& title, const Axes& axes, const std::vector<Dot>& dots) {
  constexpr int left = 90, right = 40, top = 96, panel_height = 420, below = 70, row = 19;
  std::vector<const Dot*> front;
  std::vector<double> others, usual, front_values;
  double least_x = INFINITY, most_x = 0, least_y = INFINITY, most_y = -INFINITY;
  for (const Dot& dot : dots) {
    if (!std::isfinite(dot.x) || !std::isfinite(dot.y.value)) continue;
    least_x = std::min(least_x, dot.x), most_x = std::max(most_x, dot.x);
    least_y = std::min(least_y, dot.y.value), most_y = std::max(most_y, dot.y.value);
    if (dot.on_front) {
      front.push_back(&dot);
      for (const double bound : {dot.y.low, dot.y.high}) {
        if (std::isfinite(bound)) least_y = std::min(least_y, bound), most_y = std::max(most_y, bound);
      }
    } else {
      others.insert(others.end(), {dot.x, dot.y.value});
    }
    if (dot.usual) usual.insert(usual.end(), {dot.x, dot.y.value});
  }
  std::sort(front.begin(), front.end(), [](const Dot* a, const Dot* b) { return a->x < b->x; });
  if (!(least_x <= most_x)) least_x = 1, most_x = 10, least_y = 0, most_y = 1;
  const std::size_t named = std::min(front.size(), most_named);
  const int bottom = top + panel_height, rows = static_cast<int>((named + 1) / 2);
  PlotScript script(title, page_width, bottom + below + rows * row + 16);
  script.text(axes.note, 20, 52, "left font ',12'", faint_ink);
  script.text(
      "Orange: the front, as found on the runs to choose on, with 95 % intervals; grey: other settings; ring: the usual one.", 20,
      72, "left font ',12'", faint_ink);
  for (std::size_t i = 0; i < named; ++i) {
    script.text(shortened(fmt::format("{}  {}", i + 1, front[i]->text), 62), i % 2 == 0 ? 40 : page_width / 2 + 20,
                bottom + below + static_cast<int>(i / 2) * row, "left font ',11'");
  }
  script.begin_panel({.left = left, .top = top, .right = page_width - right, .bottom = bottom});
  const double across = most_x > least_x ? most_x - least_x : std::max(1.0, most_x),
               up = std::max(most_y - least_y, 1e-3 * std::max(1.0, std::abs(most_y)));
  if (axes.log_x && least_x > 0 && most_x > 8 * least_x) {  // in less there is no decade to be named
    script.add("set logscale x\nset xrange [{:.9g}:{:.9g}]", 0.85 * least_x, 1.2 * most_x);
  } else {
    script.add("set xrange [{:.9g}:{:.9g}]", least_x - 0.04 * across, most_x + 0.06 * across);
  }
  script.add("set yrange [{:.9g}:{:.9g}]", least_y - 0.12 * up,
             std::isfinite(axes.top) ? std::max(axes.top, most_y + 0.06 * up) : most_y + 0.12 * up);
  script.add("set xlabel {} textcolor rgb '{}'\nset ylabel {} textcolor rgb '{}'", plot_text(axes.x_label), ink,
             plot_text(axes.y_label), ink);
  for (std::size_t i = 0; i < front.size(); ++i) {
    const Measured& y = front[i]->y;
    const bool has_interval = std::isfinite(y.low) && std::isfinite(y.high);
    front_values.insert(front_values.end(),
                        {front[i]->x, y.value, has_interval ? y.low : y.value, has_interval ? y.high : y.value});
    if (i < named) {
      script.add("set label '{}' at first {:.9g}, first {:.9g} left offset 0.6,0.6 font ',10' textcolor rgb '{}'", i + 1,
                 front[i]->x, y.value, ink);
    }
  }
  const std::string front_table = script.table(4, std::move(front_values));
  script.add(
      "plot {0} using 1:2 with points lc rgb '{1}' pt 7 ps 0.9 notitle, "
      "{2} using 1:2 with lines lc rgb '{3}' lw 1.2 dt 2 notitle, "
      "{2} using 1:2:3:4 with yerrorbars lc rgb '{3}' lw 1.5 pt 7 ps 1.1 notitle, "
      "{4} using 1:2 with points lc rgb '{5}' pt 6 ps 2.0 lw 1.5 notitle",
      script.table(2, std::move(others)), "#9A9A9A", front_table, figure_colours::best, script.table(2, std::move(usual)), ink);
  return std::move(script).plot();
}

std::string with_runs(const ReportedTrade& trade, const std::string& words) {
  return trade.simulated ? words + " (simulated runs)" : words;
}

Measured scaled(Measured measured, double factor) {
  measured.value *= factor, measured.low *= factor, measured.high *= factor;
  return measured;
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
                      .by_rate = {},
                      .by_history = {},
                      .by_resolution = {},
                      .sentence = json["recommendation"]["sentence"].text()};
  for (const JsonView& point : json["points"].items()) trade.settings.push_back(setting_in(point));
  for (const JsonView& pair : json["left_out"].items()) {
    trade.left_out.push_back(fmt::format("t_h {:g} ms with a tick of {:g} ms: {}", pair["th_ms"].number(),
                                         pair["tick_ms"].number(), pair["why"].text()));
  }
  for (const JsonView& one : json["not_measured"].items())
    trade.left_out.push_back(fmt::format("{}: {}", one["setting"].text(), one["why"].text()));
  if (const JsonView growth = json["growth"]) {
    trade.by_rate = growth_in(growth["rate"]);
    trade.by_history = growth_in(growth["history"]);
    trade.by_resolution = growth_in(growth["resolution"]);
  }
  return trade;
}

Plot trade_accuracy_plot(const ReportedTrade& trade) {
  std::vector<Dot> dots;
  for (const ReportedSetting& setting : trade.settings) {
    dots.push_back({.x = setting.us_p99.value,
                    .y = scaled(setting.accuracy, 100),
                    .on_front = setting.on_accuracy_front,
                    .usual = setting.design == "usual",
                    .text = setting.text});
  }
  return dots_plot(with_runs(trade, "Accuracy against time per tick"),
                   {.note = "Each dot is a setting, on the reported runs.",
                    .x_label = "time that 99 of 100 ticks do not exceed [us]",
                    .y_label = "accuracy [%]",
                    .log_x = true},
                   dots);
}

Plot trade_delay_plot(const ReportedTrade& trade) {
  std::vector<Dot> dots;
  for (const ReportedSetting& setting : trade.settings) {
    dots.push_back({.x = setting.false_alarms_per_min.value,
                    .y = scaled(setting.delay_us, 1e-3),
                    .on_front = setting.on_delay_front,
                    .usual = setting.design == "usual",
                    .text = std::isfinite(setting.missed.value)
                                ? fmt::format("{} ({:.1f} % missed)", setting.text, 100 * setting.missed.value)
                                : setting.text});
  }
  return dots_plot(with_runs(trade, "Detection delay against false alarms"),
                   {.note = "Each dot is a setting, on the reported runs; the front is that of false alarms, delay and misses.",
                    .x_label = "false alarms per minute",
                    .y_label = "mean delay [ms]"},
                   dots);
}

Plot trade_growth_plot(const ReportedTrade& trade) {
  constexpr int left = 80, right = 30, top = 100, gap = 70, panel_height = 330, below = 60;
  const int width = (page_width - left - right - 2 * gap) / 3, bottom = top + panel_height;
  PlotScript script(with_runs(trade, "How the cost of a tick grows"), page_width, bottom + below);
  script.text(
      "Solid blue: ours, all of a tick; dashed blue: its rendering. Orange: every pixel and every output computed, likewise.", 20,
      52, "left font ',12'", faint_ink);
  script.text("median time per tick [us]", 20, 78, "left font ',12'");
  double most = 1, least = INFINITY;
  for (const auto* curve : {&trade.by_rate, &trade.by_history, &trade.by_resolution}) {
    for (const ReportedGrowth& point : *curve) {
      for (const double us : {point.sparse_us, point.sparse_rendering_us, point.dense_us, point.dense_rendering_us}) {
        if (!std::isfinite(us) || us <= 0) continue;
        most = std::max(most, us), least = std::min(least, us);
      }
    }
  }
  if (!(least <= most)) least = 0.1;
  const auto panel = [&](int column, const std::vector<ReportedGrowth>& points, const std::string& label, auto x_of,
                         const std::string& tics) {
    const int begin = left + column * (width + gap);
    script.begin_panel({.left = begin, .top = top, .right = begin + width, .bottom = bottom});
    std::vector<double> values;
    for (const ReportedGrowth& point : points) {
      values.insert(values.end(),
                    {x_of(point), point.sparse_us, point.sparse_rendering_us, point.dense_us, point.dense_rendering_us});
    }
    script.add("set logscale xy\nset yrange [{:.9g}:{:.9g}]", 0.7 * least, 1.5 * most);
    if (!tics.empty()) script.add("set xtics ({})", tics);
    script.add("set xlabel {} textcolor rgb '{}'", plot_text(label), ink);
    script.add(
        "plot {0} using 1:2 with linespoints lc rgb '{1}' lw 1.8 pt 7 ps 0.8 notitle, "
        "{0} using 1:3 with lines lc rgb '{1}' lw 1.4 dt 2 notitle, "
        "{0} using 1:4 with linespoints lc rgb '{2}' lw 1.8 pt 5 ps 0.8 notitle, "
        "{0} using 1:5 with lines lc rgb '{2}' lw 1.4 dt 2 notitle",
        script.table(5, std::move(values)), figure_colours::network, figure_colours::best);
  };
  // None at all has its place left of the least rate.
  static constexpr double none_at = 3e3;
  panel(
      0, trade.by_rate, "events per second, t_h 40 ms",
      [](const ReportedGrowth& point) { return std::max(point.events_per_s, none_at); },
      fmt::format("'0' {:g}, '10^4' 1e4, '10^5' 1e5, '10^6' 1e6, '10^7' 1e7", none_at));
  panel(
      1, trade.by_history, "t_h [ms], 0.3 million events/s", [](const ReportedGrowth& point) { return point.history_ms; },
      "2, 10, 40, 200, 1000");
  panel(
      2, trade.by_resolution, "pixels, 0.3 million events/s",
      [](const ReportedGrowth& point) { return point.width * point.height; },
      "'160x120' 19200, '320x240' 76800, '640x480' 307200, '1280x960' 1228800");
  return std::move(script).plot();
}

}  // namespace tactile
