#include "tactile/labels/event_rate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tactile/core/error.hpp"
#include "tactile/events/recording_health.hpp"

namespace tactile {
namespace {

constexpr int parts = 8;
constexpr microseconds longest_run = std::chrono::hours(1);

struct Span {
  CameraTime first = CameraTime::max();
  CameraTime last = CameraTime::min();
};

Span span_of(RecordingReader& recording, std::int32_t stream_id) {
  Span span;
  for_all_events(recording, stream_id, [&](std::span<const Event> events) {
    for (const Event& event : events) {
      span.first = std::min(span.first, event.t);
      span.last = std::max(span.last, event.t);
    }
  });
  return span;
}

/// Events per pixel in the part that has the fewest: the noise of an ordinary pixel.
double quietest_mean(const std::vector<std::uint16_t>& counts) {
  std::array<double, parts> sums{};
  for (std::size_t i = 0; i < counts.size(); ++i) sums[i % parts] += counts[i];
  return *std::min_element(sums.begin(), sums.end()) * parts / static_cast<double>(counts.size());
}

/// Whether the pixel fires often in this part, and its neighbours do not.
bool is_alone(const std::vector<std::uint16_t>& counts, SensorSize size, std::size_t pixel, std::size_t part, double limit) {
  constexpr double times_neighbours = 8.0;
  const double count = counts[pixel * parts + part];
  if (count < limit) return false;
  const auto width = static_cast<std::size_t>(size.width), height = static_cast<std::size_t>(size.height);
  const std::size_t x = pixel % width, y = pixel / width;
  std::vector<std::uint16_t> neighbours;
  for (std::size_t v = y - std::min<std::size_t>(y, 1); v <= std::min(y + 1, height - 1); ++v) {
    for (std::size_t u = x - std::min<std::size_t>(x, 1); u <= std::min(x + 1, width - 1); ++u) {
      if (u != x || v != y) neighbours.push_back(counts[(v * width + u) * parts + part]);
    }
  }
  if (neighbours.empty()) return false;
  const auto middle = neighbours.begin() + static_cast<std::ptrdiff_t>(neighbours.size() / 2);
  std::nth_element(neighbours.begin(), middle, neighbours.end());
  return count >= times_neighbours * *middle;
}

/// By pixel, whether it fires throughout, or from some time on without its neighbours: a press and a slip together take half of a
/// short run, and a pixel at a marker fires in both.
std::vector<bool> hot_pixels(RecordingReader& recording, const Stream& stream, const Span& span,
                             const EventRateOptions& options) {
  const auto width = static_cast<std::size_t>(stream.size->width);
  const std::size_t pixels = width * static_cast<std::size_t>(stream.size->height);
  const double length_us = static_cast<double>(between(span.first, span.last).count()) + 1.0;
  std::vector<std::uint16_t> counts(pixels * parts);
  for_all_events(recording, stream.id, [&](std::span<const Event> events) {
    for (const Event& event : events) {
      const auto part = static_cast<std::size_t>(static_cast<double>(between(span.first, event.t).count()) * parts / length_us);
      const std::size_t pixel = static_cast<std::size_t>(event.y) * width + static_cast<std::size_t>(event.x);
      std::uint16_t& count = counts[pixel * parts + std::min<std::size_t>(part, parts - 1)];
      if (count < std::numeric_limits<std::uint16_t>::max()) ++count;
    }
  });
  const double expected = quietest_mean(counts);
  const double part_s = length_us / parts / 1e6, beyond_noise = expected + 10.0 * std::sqrt(expected);
  const double limit = std::max({2.0, options.hot_pixel_hz * part_s, beyond_noise});
  const double lone_limit = std::max({20.0, options.lone_pixel_hz * part_s, beyond_noise});
  std::vector<bool> hot(pixels);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    const auto first = counts.begin() + static_cast<std::ptrdiff_t>(pixel * parts);
    hot[pixel] = std::count_if(first, first + parts, [&](std::uint16_t count) { return count >= limit; }) >= parts - 1;
    int alone = 0;
    for (std::size_t part = 0; part < parts && !hot[pixel]; ++part)
      alone += is_alone(counts, *stream.size, pixel, part, lone_limit) ? 1 : 0;
    hot[pixel] = hot[pixel] || alone >= 2;
  }
  return hot;
}

}  // namespace

EventRate event_rate(RecordingReader& recording, std::int32_t stream_id, const EventRateOptions& options) {
  const std::string where = recording.file().string();
  const Stream& stream = recording.stream(stream_id);
  if (!stream.size) throw Error(where + ": its event stream declares no size; expected sizeX and sizeY");
  if (std::int64_t{stream.size->width} * stream.size->height > EventMeter::most_pixels) {
    throw Error(where + ": declares a sensor of " + std::to_string(stream.size->width) + "x" +
                std::to_string(stream.size->height) + " pixels; expected at most " + std::to_string(EventMeter::most_pixels) +
                " pixels");
  }
  const Span span = span_of(recording, stream_id);
  if (span.last < span.first) throw Error(where + ": holds no event; expected a recording of a run");
  const microseconds length = between(span.first, span.last);
  if (length > longest_run) {
    throw Error(where + ": spans " + std::to_string(length.count() / 1'000'000) + " s; expected a run of at most 3600 s");
  }
  const std::vector<bool> hot = hot_pixels(recording, stream, span, options);

  EventRate rate{.begin = span.first,
                 .bin = options.bin,
                 .counts = std::vector<std::uint32_t>(static_cast<std::size_t>(length / options.bin) + 1),
                 .hot_pixels = static_cast<std::size_t>(std::count(hot.begin(), hot.end(), true)),
                 .last = span.last,
                 .hot = {}};
  for (std::size_t pixel = 0; pixel < hot.size(); ++pixel) {
    if (hot[pixel]) rate.hot.push_back(static_cast<std::uint32_t>(pixel));
  }
  for_counted_events(recording, stream_id, rate, [&](const Event&, std::size_t bin) { ++rate.counts[bin]; });
  return rate;
}

void for_counted_events(RecordingReader& recording, std::int32_t stream_id, const EventRate& rate,
                        const std::function<void(const Event&, std::size_t)>& use) {
  const SensorSize size = *recording.stream(stream_id).size;
  const auto width = static_cast<std::size_t>(size.width);
  std::vector<bool> hot(width * static_cast<std::size_t>(size.height));
  for (const std::uint32_t pixel : rate.hot) hot[pixel] = true;
  for_all_events(recording, stream_id, [&](std::span<const Event> events) {
    for (const Event& event : events) {
      if (hot[static_cast<std::size_t>(event.y) * width + static_cast<std::size_t>(event.x)]) continue;
      use(event, static_cast<std::size_t>(between(rate.begin, event.t) / rate.bin));
    }
  });
}

}  // namespace tactile
