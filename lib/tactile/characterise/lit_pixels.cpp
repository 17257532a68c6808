#include "tactile/characterise/lit_pixels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "tactile/characterise/pixel_counts.hpp"
#include "tactile/characterise/readout_bins.hpp"

namespace tactile::characterise {
namespace {

constexpr std::uint32_t not_unusual = std::numeric_limits<std::uint32_t>::max();

/// By pixel, its place among the unusual ones.
std::vector<std::uint32_t> places_of(const PixelCounts& counts, const UnusualPixels& unusual) {
  std::vector<std::uint32_t> places(counts.pixels(), not_unusual);
  for (std::size_t i = 0; i < unusual.pixels.size(); ++i)
    places[counts.index_of(unusual.pixels[i])] = static_cast<std::uint32_t>(i);
  return places;
}

/// How far the events of each unusual pixel are in step with each line.
class StepMeter {
 public:
  StepMeter(const std::vector<FlickerLine>& lines, std::size_t pixels)
      : lines_(lines), pixels_(pixels), sums_(2 * pixels * lines.size()), counts_(2 * pixels), in_step_(pixels * lines.size()) {}

  void add(std::size_t pixel, bool on, double t_s) {
    const std::size_t place = 2 * pixel + (on ? 1 : 0);
    ++counts_[place];
    for (std::size_t i = 0; i < lines_.size(); ++i)
      sums_[place * lines_.size() + i] += std::polar(1.0, 2 * std::numbers::pi * lines_[i].hz.value * t_s);
  }
  void end_second() {
    for (std::size_t place = 0; place < counts_.size(); ++place) {
      const double n = counts_[place];
      if (n == 0) continue;
      for (std::size_t i = 0; i < lines_.size(); ++i) {
        InStep& sums = in_step_[place / 2 * lines_.size() + i];
        sums.parts += 1;
        sums.events += n;
        sums.pairs += n * (n - 1);
        sums.power += std::norm(sums_[place * lines_.size() + i]);
      }
    }
    std::fill(sums_.begin(), sums_.end(), std::complex<double>{});
    std::fill(counts_.begin(), counts_.end(), 0.0);
  }
  bool is_lit(std::size_t pixel, std::size_t line) const {
    constexpr double least_share = 0.5, least_chance = 1e-3;
    const InStep& sums = in_step_[pixel * lines_.size() + line];
    if (sums.events == 0 || sums.power - sums.events < least_share * least_share * sums.pairs) return false;
    return chance_of(sums.power / sums.events, sums.parts) * static_cast<double>(in_step_.size()) < least_chance;
  }
  /// Of the rate of the pixels that are lit at a line.
  Measured depth(std::size_t line) const {
    double excess = 0, pairs = 0, events = 0;
    for (std::size_t pixel = 0; pixel < pixels_; ++pixel) {
      if (!is_lit(pixel, line)) continue;
      const InStep& sums = in_step_[pixel * lines_.size() + line];
      excess += sums.power - sums.events;
      pairs += sums.pairs;
      events += sums.events;
    }
    const double depth = 2 * std::sqrt(excess / std::max(1.0, pairs));
    return {depth, std::hypot(std::sqrt(2 / std::max(1.0, events)), 0.02 * depth)};
  }

 private:
  struct InStep {
    double parts = 0, events = 0, pairs = 0, power = 0;
  };
  std::vector<FlickerLine> lines_;
  std::size_t pixels_;
  std::vector<std::complex<double>> sums_;  ///< of this second, by pixel, polarity, line
  std::vector<double> counts_;
  std::vector<InStep> in_step_;  ///< by pixel, line
};

/// The lines of all pixels and those of the unusual ones, which are further from the first than the resolution.
struct Lines {
  std::vector<FlickerLine> lines;
  std::size_t of_all = 0;  ///< the first so many are of all pixels
};

Lines lines_of(const Flicker& ordinary, const Flicker& few) {
  constexpr std::size_t most_lines = 32;
  Lines found{.lines = ordinary.lines, .of_all = ordinary.lines.size()};
  for (const FlickerLine& line : few.lines) {
    const auto is_near = [&](const FlickerLine& other) {
      return std::abs(other.hz.value - line.hz.value) <= 2 * ordinary.resolution_hz;
    };
    if (std::none_of(ordinary.lines.begin(), ordinary.lines.end(), is_near)) found.lines.push_back(line);
  }
  std::sort(found.lines.begin() + static_cast<std::ptrdiff_t>(found.of_all), found.lines.end(),
            [](const FlickerLine& a, const FlickerLine& b) { return a.chance < b.chance; });
  found.lines.resize(std::min(found.lines.size(), std::max(found.of_all, most_lines)));
  return found;
}

/// Leaves out lines of unusual pixels that too few of them are in step with, and marks the pixels that are.
void keep_lit_lines(LightReading& light, const Lines& found, const StepMeter& steps, const FirstReading& first,
                    const UnusualPixels& unusual) {
  constexpr std::size_t fewest_lit = 3;
  light.flicker.lines.clear();
  for (std::size_t i = 0; i < found.lines.size(); ++i) {
    FlickerLine line = found.lines[i];
    std::vector<std::size_t> lit;
    for (std::size_t pixel = 0; pixel < unusual.pixels.size(); ++pixel) {
      if (steps.is_lit(pixel, i)) lit.push_back(pixel);
    }
    if (i >= found.of_all && lit.size() < fewest_lit) continue;
    line.lit_pixels = lit.size();
    line.is_local = i >= found.of_all;
    if (line.is_local) line.depth = steps.depth(i);
    for (const std::size_t pixel : lit) light.lit[first.counts.index_of(unusual.pixels[pixel])] = true;
    light.flicker.lines.push_back(line);
  }
  std::sort(light.flicker.lines.begin(), light.flicker.lines.end(),
            [](const FlickerLine& a, const FlickerLine& b) { return a.hz.value < b.hz.value; });
}

}  // namespace

LightReading read_light(const FirstReading& first, const UnusualPixels& unusual, const CharacteriseOptions& options,
                        const ProgressCallback& progress) {
  const std::vector<std::uint32_t> places = places_of(first.counts, unusual);
  const auto for_events = [&](const auto& begin, const auto& use) {
    for (const ReadRecording& recording : first.recordings) {
      OpenRecording open(recording.file, options, first.counts.size);
      begin(recording);
      open.for_packets(
          recording.stretch(),
          [&](std::span<const events::Event> events) {
            for (const events::Event& event : events)
              use(event, between(recording.first, event.t).count(), places[first.counts.index_of(event)]);
          },
          progress);
    }
  };
  const double readout_us = first.readout.kind == events::Readout::Kind::none ? 0 : first.readout.period_us.value;
  FlickerMeter ordinary(ReadoutBins(first.readout).length_us, readout_us, first.shortest());
  FlickerMeter few = ordinary;
  ReadoutBins bins(first.readout);
  for_events(
      [&](const ReadRecording& recording) {
        bins = ReadoutBins(first.readout_of(recording));
        ordinary.begin_recording();
        few.begin_recording();
      },
      [&](const events::Event& event, std::int64_t t_us, std::uint32_t place) {
        (place == not_unusual ? ordinary : few).add(bins.index_of(t_us, event));
      });
  LightReading light{.flicker = ordinary.flicker(), .lit = std::vector<bool>(first.counts.pixels())};
  const Flicker of_few = few.flicker();
  const Lines found = lines_of(light.flicker, of_few);
  light.flicker.lines = found.lines;
  if (unusual.pixels.empty() || found.lines.empty()) return light;

  StepMeter steps(found.lines, unusual.pixels.size());
  std::int64_t second = 0;
  for_events(
      [&](const ReadRecording&) {
        steps.end_second();
        second = 0;
      },
      [&](const events::Event& event, std::int64_t t_us, std::uint32_t place) {
        if (place == not_unusual) return;
        if (t_us / 1'000'000 > second) steps.end_second();
        second = std::max(second, t_us / 1'000'000);
        steps.add(place, event.on != 0, static_cast<double>(t_us) * 1e-6);
      });
  steps.end_second();
  keep_lit_lines(light, found, steps, first, unusual);
  const std::vector<FlickerLine>& lines = light.flicker.lines;
  if (std::any_of(lines.begin(), lines.end(), [](const FlickerLine& line) { return line.is_local; })) {
    for (std::size_t i = 0; i < of_few.spectrum.size(); ++i)
      light.flicker.spectrum[i] = std::max(light.flicker.spectrum[i], of_few.spectrum[i]);
  }
  return light;
}

}  // namespace tactile::characterise
