#include "tactile/pictures/sensor_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tactile/pictures/plot_script.hpp"

namespace tactile::pictures {
namespace {

using characterise::Sensor;
using characterise::UnusualPixel;
using Kind = UnusualPixel::Kind;

constexpr int width = 1600, height = 1150;
constexpr int left = 90, middle = 880, top = 130, lower = 690, panel_width = 640, panel_height = 400;

std::string value_text(const Measured& m, double unit, int digits) {
  return fmt::format("{:.{}f} ± {:.{}f}", m.value * unit, digits, m.uncertainty * unit, digits);
}

void begin(PlotScript& script, int x, int y, std::string_view title) {
  script.begin_panel({x, y, x + panel_width, y + panel_height});
  script.text(title, x, y - 16, "left font ',13'");
}

double limit_of(const std::vector<double>& values, double least) {
  double most = least;
  for (const double value : values) {
    if (std::isfinite(value)) most = std::max(most, std::abs(value));
  }
  return 1.1 * most;
}

/// A panel without anything to show.
void say(PlotScript& script, int x, int y, std::string_view words) {
  script.text(words, x + panel_width / 2.0, y + panel_height / 2.0, "center font ',13'", figure_colours::faint_ink);
  script.axes({0, 1, "", "", "", false}, {0, 1, "", "", "", false});
  script.plot({{script.table(2, {}), "1:2", "lines", line_style(0)}});
}

void draw_lines(PlotScript& script, const Sensor& sensor) {
  const events::Readout& readout = sensor.readout;
  if (readout.line_offsets_us.empty()) {
    begin(script, left, top, "Read-out");
    const bool is_steady = readout.kind == events::Readout::Kind::steady;
    say(script, left, top,
        is_steady ? fmt::format("every {} µs, all pixels at once", value_text(readout.period_us, 1, 4))
                  : std::string("no steady period"));
    return;
  }
  const std::string_view line = readout.scan == events::Scan::columns ? "column" : "row";
  begin(script, left, top,
        fmt::format("Read-out: every {:.4f} µs, {:.5f} µs from {} to {}", readout.period_us.value, readout.step_us.value, line,
                    line));
  std::vector<double> points;
  for (std::size_t i = 0; i < readout.line_offsets_us.size(); ++i) {
    points.push_back(static_cast<double>(i));
    points.push_back(readout.line_offsets_us[i]);
  }
  const double limit = limit_of(readout.line_offsets_us, 0.05);
  script.axes({0, static_cast<double>(readout.lines), line}, {-limit, limit, "stamps against a straight line [µs]"});
  LineStyle style = line_style(0);
  style.mark = 7;
  style.size = 0.35;
  script.plot({{script.table(2, points), "1:2", "points", style}});
}

void draw_rates(PlotScript& script, const Sensor& sensor) {
  begin(script, middle, top,
        fmt::format("Rates of pixels: ordinary {:.4f} ON, {:.4f} OFF per s", sensor.background.on_hz.value,
                    sensor.background.off_hz.value));
  const auto pixels = static_cast<double>(sensor.size.width) * sensor.size.height;
  std::vector<double> ordinary, unusual;
  double most = 1;
  const std::vector<double>& rates = sensor.background_rates_hz;
  const double shared = pixels - static_cast<double>(sensor.unusual.pixels.size());
  for (std::size_t i = 0; i < rates.size(); ++i) {
    const double rank = shared * (1 - static_cast<double>(i) / static_cast<double>(rates.size() - 1)) + (pixels - shared) + 1;
    ordinary.insert(ordinary.end(), {std::log10(std::min(rank, pixels)), rates[i] > 0 ? std::log10(rates[i]) : -3});
  }
  for (std::size_t i = 0; i < sensor.unusual.pixels.size(); ++i) {
    const double rate = sensor.unusual.pixels[i].rate_hz.value;
    unusual.insert(unusual.end(), {std::log10(static_cast<double>(i) + 1), std::log10(rate)});
    most = std::max(most, rate);
  }
  script.axes({0, std::log10(pixels) + 0.05, "pixels that fire more often",
               "'1' 0, '10' 1, '100' 2, '1000' 3, '10⁴' 4, '10⁵' 5, '10⁶' 6, '10⁷' 7"},
              {-2, std::ceil(std::log10(most) + 0.01), "events per s",
               "'0.01' -2, '0.1' -1, '1' 0, '10' 1, '100' 2, '1000' 3, '10⁴' 4, '10⁵' 5"});
  LineStyle marks = line_style(1);
  marks.mark = 7;
  marks.size = 0.5;
  script.plot({{script.table(2, ordinary), "1:2", "lines", line_style(0)}, {script.table(2, unusual), "1:2", "points", marks}});
}

void draw_map(PlotScript& script, const Sensor& sensor) {
  const characterise::UnusualPixels& unusual = sensor.unusual;
  begin(script, left, lower,
        fmt::format("{:.0f} hot (orange), {:.0f} stuck (black), {:.0f} warm (blue) pixels{}", unusual.hot.value,
                    unusual.stuck.value, unusual.warm.value, unusual.lit > 0 ? fmt::format(", {} lit (grey)", unusual.lit) : ""));
  std::array<std::vector<double>, 4> places;
  for (const UnusualPixel& pixel : sensor.unusual.pixels) {
    auto& list = places[static_cast<std::size_t>(pixel.kind)];
    list.insert(list.end(), {static_cast<double>(pixel.x), static_cast<double>(pixel.y)});
  }
  script.axes({0, static_cast<double>(sensor.size.width), "x [px]"}, {static_cast<double>(sensor.size.height), 0, "y [px]"});
  const auto style = [](std::string_view colour, double size) {
    return LineStyle{.colour = colour, .width = 1, .dashes = 1, .mark = 7, .size = size, .fill = 0};
  };
  script.plot(
      {{script.table(2, places[static_cast<std::size_t>(Kind::lit)]), "1:2", "points", style(figure_colours::others, 0.4)},
       {script.table(2, places[static_cast<std::size_t>(Kind::warm)]), "1:2", "points", style(line_style(0).colour, 0.4)},
       {script.table(2, places[static_cast<std::size_t>(Kind::hot)]), "1:2", "points", style(line_style(1).colour, 0.7)},
       {script.table(2, places[static_cast<std::size_t>(Kind::stuck)]), "1:2", "points", style(figure_colours::ink, 1.2)}});
}

void draw_spectrum(PlotScript& script, const Sensor& sensor) {
  const characterise::Flicker& flicker = sensor.flicker;
  if (flicker.to_hz <= flicker.from_hz || flicker.spectrum.empty()) {
    begin(script, middle, lower, "Flicker");
    say(script, middle, lower, "too few events or too slow read-outs to search for it");
    return;
  }
  std::string title =
      flicker.lines.empty() ? fmt::format("Flicker: none from {:.0f} to {:.0f} Hz", flicker.from_hz, flicker.to_hz) : "Flicker:";
  const std::vector<characterise::FlickerSeries> series = characterise::series_of(flicker);
  constexpr std::size_t most_series = 2;
  for (std::size_t i = 0; i < std::min(most_series, series.size()); ++i)
    title += fmt::format("{} {} Hz{} ({:.1f} %)", i == 0 ? "" : ",", value_text(series[i].line.hz, 1, 2),
                         series[i].multiples > 0 ? " and multiples" : "", 100 * series[i].line.depth.value);
  if (series.size() > most_series) title += " …";
  begin(script, middle, lower, title);
  std::vector<double> points, lines;
  double most = 2;
  for (std::size_t i = 1; i < flicker.spectrum.size(); ++i) {
    const double hz = static_cast<double>(i) * flicker.resolution_hz;
    if (hz < flicker.from_hz || hz > flicker.to_hz || !(flicker.spectrum[i] > 0)) continue;
    points.insert(points.end(), {hz, 10 * std::log10(flicker.spectrum[i])});
    most = std::max(most, points.back());
  }
  for (const characterise::FlickerLine& line : flicker.lines) lines.insert(lines.end(), {line.hz.value, most + 0.5});
  script.axes({0, flicker.to_hz, "frequency [Hz]"}, {-5, most + 2, "power against its surroundings [dB]"});
  LineStyle marks = line_style(1);
  marks.mark = 11;
  script.plot({{script.table(2, points), "1:2", "lines", line_style(0)}, {script.table(2, lines), "1:2", "points", marks}});
}

}  // namespace

void draw_sensor(const Sensor& sensor, const std::filesystem::path& file) {
  const std::string camera = sensor.camera.empty() ? "A sensor" : sensor.camera;
  PlotHead head(
      fmt::format("{}: {} x {} pixels, {} events in {:.3f} s {}", camera, sensor.size.width, sensor.size.height, sensor.events,
                  sensor.seconds, sensor.background.is_disturbed() ? "with motion or flicker" : "without touch"),
      width);
  head.note(fmt::format(
      "{:.1f} thousand events per s, {:.1f} without hot pixels, which have {} % of the events. Uncertainties are one standard "
      "deviation.",
      sensor.rate_hz.value / 1000, sensor.rate_without_hot_hz.value / 1000, value_text(sensor.unusual.hot_share, 100, 1)));
  PlotScript script(std::move(head), height);
  draw_lines(script, sensor);
  draw_rates(script, sensor);
  draw_map(script, sensor);
  draw_spectrum(script, sensor);
  draw(std::move(script).finished(), file);
}

}  // namespace tactile::pictures
