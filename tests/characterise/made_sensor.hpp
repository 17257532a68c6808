#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <vector>

#include "events/aedat4_bytes.hpp"
#include "tactile/core/measured.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::test {

/// A sensor whose noise is known.
struct MadeSensor {
  struct Hot {
    int x = 0, y = 0;
    double hz = 0;
  };
  events::SensorSize size{80, 60};
  double seconds = 10;
  double period_us = 195.163, step_us = -2.2;  ///< of read-outs, from column to column
  double background_hz = 2, on_share = 0.6;    ///< per pixel; the mean of log-normal rates
  double spread_decades = 0.2;
  int shape = 2;  ///< of gamma-distributed intervals
  std::vector<Hot> hot{};
  std::vector<std::pair<int, int>> dead{};
  double flicker_hz = 0, flicker_depth = 0;  ///< of the rate; with shape 1
};

/// Its events: each is stamped at the next read-out of its column, a pixel at most once a read-out.
inline std::vector<events::Event> events_of(const MadeSensor& sensor, std::uint64_t seed) {
  Random random(seed);
  std::vector<events::Event> events;
  const double ln_spread = sensor.spread_decades * std::numbers::ln10;
  for (int y = 0; y < sensor.size.height; ++y) {
    for (int x = 0; x < sensor.size.width; ++x) {
      double hz = sensor.background_hz * std::exp(ln_spread * random.normal() - ln_spread * ln_spread / 2);
      for (const MadeSensor::Hot& hot : sensor.hot) hz = hot.x == x && hot.y == y ? hot.hz : hz;
      if (std::find(sensor.dead.begin(), sensor.dead.end(), std::pair(x, y)) != sensor.dead.end()) continue;
      hz *= 1 + sensor.flicker_depth;
      std::int64_t last = -1;
      double t = -20 * sensor.shape / hz * random.uniform();
      while (true) {
        for (int i = 0; i < sensor.shape; ++i) t += random.exponential() / (hz * sensor.shape);
        if (t >= sensor.seconds) break;
        if (t < 0) continue;
        const double light = 1 + sensor.flicker_depth * std::sin(2 * std::numbers::pi * sensor.flicker_hz * t);
        if (random.uniform() * (1 + sensor.flicker_depth) > light) continue;
        const double offset = 1000 + sensor.step_us * x;
        const std::int64_t readout = static_cast<std::int64_t>(std::ceil((1e6 * t - offset) / sensor.period_us));
        if (readout == last) continue;
        last = readout;
        events::Event event;
        event.t = camera_time(1'000'000 + std::llround(offset + sensor.period_us * static_cast<double>(readout)));
        event.x = static_cast<std::int16_t>(x);
        event.y = static_cast<std::int16_t>(y);
        event.on = random.uniform() < sensor.on_share ? 1 : 0;
        events.push_back(event);
      }
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const events::Event& a, const events::Event& b) { return a.t < b.t; });
  return events;
}

/// Its events, and those of edges that cross it at 50 px/s, one each 10 pixels: each is seen by a column within 2 ms.
inline std::vector<events::Event> with_edges(const MadeSensor& sensor, std::vector<events::Event> events) {
  constexpr std::int64_t us_per_pixel = 20'000, apart = 10;
  Random random(21);
  for (std::int64_t step = 0; step < static_cast<std::int64_t>(1e6 * sensor.seconds) / us_per_pixel; ++step) {
    for (std::int64_t x = step % apart; x < sensor.size.width; x += apart) {
      for (int y = 0; y < sensor.size.height; ++y) {
        const auto late = static_cast<std::int64_t>(2'000 * random.uniform());
        events.push_back(event(1'000'000 + us_per_pixel * step + late, static_cast<int>(x), y, 1));
      }
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return events;
}

/// Its events, and those of all pixels in light that is pulsed: each fires at three of ten pulses, within a millisecond.
inline std::vector<events::Event> with_pulses(const MadeSensor& sensor, std::vector<events::Event> events, double hz) {
  Random random(22);
  for (int pulse = 0; pulse < static_cast<int>(hz * sensor.seconds); ++pulse) {
    for (int pixel = 0; pixel < sensor.size.width * sensor.size.height; ++pixel) {
      if (random.uniform() > 0.3) continue;
      const double t_us = 1'000'000 + 1e6 / hz * pulse + 1'000 * random.uniform();
      events.push_back(event(std::llround(t_us), pixel % sensor.size.width, pixel / sensor.size.width, 1));
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return events;
}

/// @return  the file
inline std::filesystem::path write_recording(const std::filesystem::path& file, events::SensorSize size,
                                             const std::vector<events::Event>& events) {
  events::RecordingWriter writer(file, {events::event_stream_declaration(size, "Made")},
                                 {.compression = events::Compression::none});
  writer.write_events(0, events);
  writer.close();
  return file;
}

/// How many standard uncertainties a measured value lies off.
inline double off_by(const Measured& measured, double truth) {
  return std::abs(measured.value - truth) / std::max(measured.uncertainty, 1e-12);
}

}  // namespace tactile::test
