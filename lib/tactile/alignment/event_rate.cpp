#include "tactile/alignment/event_rate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
#include <opencv2/core.hpp>

#include "tactile/core/error.hpp"
#include "tactile/events/recording_health.hpp"

namespace tactile::alignment {
namespace {

constexpr int parts = 8;

struct Span {
  CameraTime first{}, last{};
  bool empty = true;
  std::optional<double> readout_us;
};

Span span_of(events::RecordingReader& recording, std::int32_t stream_id) {
  events::EventMeter meter(std::nullopt, {});
  events::for_all_events(recording, stream_id, [&](std::span<const events::Event> events) { meter.add_packet(events); });
  const events::StampHealth stamps = meter.stamps();
  Span span{.first = stamps.first, .last = stamps.last, .empty = stamps.elements == 0, .readout_us = {}};
  const events::Readout readout = meter.health().readout;
  if (readout.kind != events::Readout::Kind::none) span.readout_us = readout.period_us.value;
  return span;
}

/// Bins that hold no whole number of read-outs would beat: some would hold one more than others.
microseconds whole_readouts(microseconds bin, const std::optional<double>& readout_us) {
  if (!readout_us) return bin;  // every event has its own time, there are no read-outs
  const std::int64_t readout = std::llround(*readout_us);
  return microseconds{readout * std::max<std::int64_t>(1, (bin.count() + readout / 2) / readout)};
}

/// Events per pixel in the part that has the fewest: the noise of an ordinary pixel.
double quietest_mean(const std::vector<std::uint16_t>& counts) {
  std::array<double, parts> sums{};
  for (std::size_t i = 0; i < counts.size(); ++i) sums[i % parts] += counts[i];
  return *std::min_element(sums.begin(), sums.end()) * parts / static_cast<double>(counts.size());
}

/// By pixel, whether it fires throughout. A press and a slip together take half of a short run, and a pixel at a marker fires in
/// both.
std::vector<bool> hot_pixels(events::RecordingReader& recording, const events::Stream& stream, const Span& span,
                             double hot_pixel_hz) {
  const auto width = static_cast<std::size_t>(stream.size->width);
  const std::size_t pixels = width * static_cast<std::size_t>(stream.size->height);
  const double length_us = static_cast<double>(between(span.first, span.last).count()) + 1.0;
  std::vector<std::uint16_t> counts(pixels * parts);
  events::for_all_events(recording, stream.id, [&](std::span<const events::Event> events) {
    for (const events::Event& event : events) {
      const auto part = static_cast<std::size_t>(static_cast<double>(between(span.first, event.t).count()) * parts / length_us);
      const std::size_t pixel = static_cast<std::size_t>(event.y) * width + static_cast<std::size_t>(event.x);
      std::uint16_t& count = counts[pixel * parts + std::min<std::size_t>(part, parts - 1)];
      if (count < std::numeric_limits<std::uint16_t>::max()) ++count;
    }
  });
  const double expected = quietest_mean(counts);
  const double limit = std::max({2.0, hot_pixel_hz * length_us / parts / 1e6, expected + 10.0 * std::sqrt(expected)});
  const auto height = pixels / width;
  const auto count_in = [&](std::size_t pixel, int part) {
    return static_cast<double>(counts[pixel * parts + static_cast<std::size_t>(part)]);
  };
  // From when it became hot, or until it healed.
  const auto fires_at_an_end = [&](std::size_t pixel, int outer, int inner) {
    const double there = count_in(pixel, outer), next = count_in(pixel, inner);
    if (there < limit || next < std::max(limit, 0.5 * there - 3.0 * std::sqrt(there))) return false;
    const std::size_t x = pixel % width, y = pixel / width;
    double most = 0, second = 0;
    for (std::size_t v = y - std::min<std::size_t>(y, 2); v <= std::min(height - 1, y + 2); ++v) {
      for (std::size_t u = x - std::min<std::size_t>(x, 2); u <= std::min(width - 1, x + 2); ++u) {
        if (u == x && v == y) continue;
        const double beside = count_in(v * width + u, outer);
        second = std::max(second, std::min(most, beside));
        most = std::max(most, beside);
      }
    }
    return there >= 5.0 * second;
  };
  std::vector<bool> hot(pixels);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    const auto first = counts.begin() + static_cast<std::ptrdiff_t>(pixel * parts);
    hot[pixel] = std::count_if(first, first + parts, [&](std::uint16_t count) { return count >= limit; }) >= parts - 1 ||
                 fires_at_an_end(pixel, parts - 1, parts - 2) || fires_at_an_end(pixel, 0, 1);
  }
  return hot;
}

/// The number of bins with the greatest count, unless it is due to chance: without a limit, few such high counts occur twice.
std::size_t saturated_bins_of(const std::vector<std::uint32_t>& counts) {
  constexpr std::size_t least = 20;
  const std::uint32_t most = *std::max_element(counts.begin(), counts.end());
  const auto at_most = static_cast<std::size_t>(std::count(counts.begin(), counts.end(), most));
  if (most < 10 || at_most < least) return 0;
  // The mean number of bins per count, from 3/4 of the greatest on.
  const std::uint32_t from = most - most / 4;
  const auto near = static_cast<double>(
      std::count_if(counts.begin(), counts.end(), [&](std::uint32_t count) { return count >= from && count < most; }));
  return static_cast<double>(at_most) > 10.0 * near / static_cast<double>(most - from) ? at_most : 0;
}

/// The index of the strongest frequency of [lowest, highest] in a window of counts, if it has at least `share` of their variance.
/// @param counts  one row; frequency k has k periods in it
std::optional<std::size_t> strongest_frequency(const cv::Mat1d& counts, std::size_t lowest, std::size_t highest, double share) {
  cv::Mat1d roots;
  cv::sqrt(counts + 0.375, roots);  // the noise of 2 sqrt(n + 3/8) is 1 whatever the rate (Anscombe)
  roots *= 2.0;
  roots -= cv::mean(roots)[0];
  const double variance = roots.dot(roots);
  if (!(variance > 0)) return std::nullopt;
  cv::Mat2d spectrum;
  cv::dft(roots, spectrum, cv::DFT_COMPLEX_OUTPUT);
  double best = 0;
  std::size_t best_k = 0;
  for (std::size_t k = lowest; k <= highest; ++k) {
    const cv::Vec2d& value = spectrum(0, static_cast<int>(k));
    const double power = 2.0 * value.dot(value) / static_cast<double>(counts.cols);
    if (power <= best) continue;
    best = power;
    best_k = k;
  }
  return best < share * variance ? std::nullopt : std::optional(best_k);
}

/// The power of one frequency in the first values, which hold `periods` of it per `n`.
double power_at(const std::vector<std::int32_t>& values, std::size_t n, double periods) {
  std::complex<double> sum = 0;
  for (std::size_t i = 0; i < values.size() / n * n; ++i)
    sum += static_cast<double>(values[i]) *
           std::polar(1.0, -2.0 * std::numbers::pi * periods * static_cast<double>(i) / static_cast<double>(n));
  return std::norm(sum);
}

/// The frequency of the light: one that has at least `share` of the rate's variance in most quarters of a second, and is the same
/// in most of them. A light that swings gives brighter events, then darker ones: the rate then has twice its frequency.
/// @param brighter_less_darker  events per bin
std::optional<double> flicker_of(const std::vector<std::uint32_t>& counts, const std::vector<std::int32_t>& brighter_less_darker,
                                 microseconds bin, double share) {
  constexpr double window_s = 0.25, lowest_hz = 40.0, highest_hz = 1000.0;
  constexpr std::size_t most_windows = 120;  // half a minute is enough
  const double bin_s = 1e-6 * static_cast<double>(bin.count());
  const auto n = static_cast<std::size_t>(window_s / bin_s);
  if (n < 50 || counts.size() < 2 * n) return std::nullopt;
  const auto lowest = static_cast<std::size_t>(lowest_hz * window_s);
  const auto highest = std::min(static_cast<std::size_t>(highest_hz * window_s), n / 2 - 1);
  std::vector<std::size_t> votes(highest + 1);
  const std::size_t windows = std::min(counts.size() / n, most_windows);
  for (std::size_t i = 0; i < windows; ++i) {
    cv::Mat1d window(1, static_cast<int>(n));
    std::copy_n(counts.begin() + static_cast<std::ptrdiff_t>(i * n), n, window.begin());
    if (const auto strongest = strongest_frequency(window, lowest, highest, share)) ++votes[*strongest];
  }
  if (2 * std::accumulate(votes.begin(), votes.end(), std::size_t{0}) <= windows) return std::nullopt;
  const auto top = static_cast<std::size_t>(std::max_element(votes.begin(), votes.end()) - votes.begin());
  const std::size_t near = votes[top] + (top > 0 ? votes[top - 1] : 0) + (top < highest ? votes[top + 1] : 0);
  if (2 * near <= windows) return std::nullopt;
  const std::vector<std::int32_t> first(brighter_less_darker.begin(),
                                        brighter_less_darker.begin() + static_cast<std::ptrdiff_t>(n));
  const auto periods = static_cast<double>(top);
  const bool is_double = power_at(first, n, 0.5 * periods) > power_at(first, n, periods);
  return (is_double ? 0.5 : 1.0) * periods / (static_cast<double>(n) * bin_s);
}

}  // namespace

EventRate event_rate(events::RecordingReader& recording, std::int32_t stream_id, const EventRateOptions& options) {
  const std::string where = recording.file().string();
  const events::Stream& stream = recording.stream(stream_id);
  if (!stream.size) throw Error(where + ": its event stream declares no size; expected sizeX and sizeY");
  if (std::int64_t{stream.size->width} * stream.size->height > events::EventMeter::most_pixels) {
    throw Error(where + ": declares a sensor of " + std::to_string(stream.size->width) + "x" +
                std::to_string(stream.size->height) + " pixels; expected at most " +
                std::to_string(events::EventMeter::most_pixels) + " pixels");
  }
  const Span span = span_of(recording, stream_id);
  if (span.empty) throw Error(where + ": holds no event; expected a recording of a run");
  const microseconds length = between(span.first, span.last);
  if (length > options.longest) {
    throw Error(where + ": spans " + std::to_string(length.count() / 1'000'000) + " s; expected a run of at most " +
                std::to_string(options.longest.count() / 1'000'000) + " s; 'tactile split' cuts longer recordings into runs");
  }
  std::vector<bool> hot = hot_pixels(recording, stream, span, options.hot_pixel_hz);
  const events::PixelMask mask(*stream.size, options.mask, where + ": mask");
  for (const auto& [x, y] : mask.pixels())
    hot[static_cast<std::size_t>(y) * static_cast<std::size_t>(stream.size->width) + static_cast<std::size_t>(x)] = true;

  const microseconds bin = whole_readouts(options.bin, span.readout_us);
  EventRate rate{.begin = span.first,
                 .bin = bin,
                 .counts = std::vector<std::uint32_t>(static_cast<std::size_t>(length / bin) + 1),
                 .hot_pixels = static_cast<std::size_t>(std::count(hot.begin(), hot.end(), true)),
                 .last = span.last,
                 .hot = {},
                 .saturated_bins = 0,
                 .flicker_hz = {}};
  for (std::size_t pixel = 0; pixel < hot.size(); ++pixel) {
    if (hot[pixel]) rate.hot.push_back(static_cast<std::uint32_t>(pixel));
  }
  // The limit of a read-out applies to all its events, those of hot pixels too.
  std::vector<std::uint32_t> all(rate.counts.size());
  std::vector<std::int32_t> brighter_less_darker(rate.counts.size());
  const auto width = static_cast<std::size_t>(stream.size->width);
  events::for_all_events(recording, stream_id, [&](std::span<const events::Event> events) {
    for (const events::Event& event : events) {
      const auto at = static_cast<std::size_t>(between(rate.begin, event.t) / rate.bin);
      ++all[at];
      if (hot[static_cast<std::size_t>(event.y) * width + static_cast<std::size_t>(event.x)]) continue;
      ++rate.counts[at];
      brighter_less_darker[at] += event.on ? 1 : -1;
    }
  });
  rate.saturated_bins = saturated_bins_of(all);
  rate.flicker_hz = flicker_of(rate.counts, brighter_less_darker, rate.bin, options.flickers);
  return rate;
}

EventRate part_of(const EventRate& rate, std::size_t begin, std::size_t end) {
  EventRate part;
  part.begin = rate.begin_of(begin);
  part.bin = rate.bin;
  part.counts.assign(rate.counts.begin() + static_cast<std::ptrdiff_t>(begin),
                     rate.counts.begin() + static_cast<std::ptrdiff_t>(end));
  part.last = end < rate.counts.size() ? before(rate.begin_of(end), 1us) : rate.last;
  part.hot_pixels = rate.hot_pixels;
  part.hot = rate.hot;
  part.is_part = true;
  return part;
}

void for_counted_events(events::RecordingReader& recording, std::int32_t stream_id, const EventRate& rate,
                        const std::function<void(const events::Event&, std::size_t)>& use) {
  const events::SensorSize size = *recording.stream(stream_id).size;
  const auto width = static_cast<std::size_t>(size.width);
  std::vector<bool> hot(width * static_cast<std::size_t>(size.height));
  for (const std::uint32_t pixel : rate.hot) hot[pixel] = true;
  const auto is_outside = [&](const events::PacketRecord& packet) {
    return packet.last < rate.begin || packet.first > rate.last;
  };
  for (const events::PacketRecord& packet : recording.packets()) {
    if (packet.stream_id != stream_id || (rate.is_part && is_outside(packet))) continue;
    for (const events::Event& event : recording.read_events(packet)) {
      const auto bin = static_cast<std::size_t>(between(rate.begin, event.t) / rate.bin);
      if (event.t < rate.begin || bin >= rate.counts.size()) continue;
      if (hot[static_cast<std::size_t>(event.y) * width + static_cast<std::size_t>(event.x)]) continue;
      use(event, bin);
    }
  }
}

}  // namespace tactile::alignment
