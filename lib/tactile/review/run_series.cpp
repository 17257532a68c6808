#include "tactile/review/run_series.hpp"

#include <cmath>
#include <limits>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/pictures/run_picture.hpp"

namespace tactile::review {
namespace {

constexpr double m_per_mm = 1e-3;

void add_sample(SampledSignal& signal, std::int64_t t_us, double value) {
  // The robot's pieces may overlap where a clock restarts; a picture's line has no way back.
  if (!signal.t_us.empty() && t_us <= signal.t_us.back()) return;
  signal.t_us.push_back(t_us);
  signal.values.push_back(static_cast<float>(value));
}

/// A trace continues a signal after a gap.
void append_trace(SampledSignal& signal, const pictures::Trace& trace, CameraTime first, double factor) {
  constexpr std::int64_t step = 1;
  if (!signal.t_us.empty()) add_sample(signal, signal.t_us.back() + step, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < trace.t.size(); ++i)
    add_sample(signal, between(first, trace.t[i]).count(), factor * trace.values[i]);
}

}  // namespace

std::vector<SampledSignal> placed_series(const alignment::RunSignals& signals, const labels::Labels& labels, CameraTime first) {
  SampledSignal speed{.name = "robot_speed", .unit = "m/s", .label = "Robot speed", .t_us = {}, .values = {}};
  SampledSignal height{.name = "robot_height", .unit = "m", .label = "Robot height", .t_us = {}, .values = {}};
  SampledSignal film{.name = "film_motion", .unit = "grey levels/s", .label = "Motion in the film", .t_us = {}, .values = {}};
  for (const pictures::Trace& trace : pictures::picture_of(signals, labels).traces) {
    if (trace.kind == pictures::TraceKind::tcp_speed) append_trace(speed, trace, first, m_per_mm);
    if (trace.kind == pictures::TraceKind::tcp_height) append_trace(height, trace, first, m_per_mm);
    if (trace.kind == pictures::TraceKind::video_energy) append_trace(film, trace, first, 1);
  }
  std::vector<SampledSignal> series;
  for (SampledSignal* signal : {&speed, &height, &film}) {
    if (!signal->t_us.empty()) series.push_back(std::move(*signal));
  }
  return series;
}

SampledSignal imu_series(std::span<const events::ImuSample> samples, CameraTime first) {
  std::vector<double> sizes;
  sizes.reserve(samples.size());
  for (const events::ImuSample& sample : samples) sizes.push_back(sample.acceleration());
  SampledSignal series{.name = "imu", .unit = "m/s2", .label = "Acceleration of the camera", .t_us = {}, .values = {}};
  const double rest = sizes.empty() ? 0 : median(sizes);
  for (std::size_t i = 0; i < sizes.size(); ++i) add_sample(series, between(first, samples[i].t).count(), sizes[i] - rest);
  return series;
}

std::array<SampledSignal, touch_count> probability_series(const results::FullRun& run, CameraTime first) {
  std::array<SampledSignal, touch_count> series;
  for (const Touch touch : all_touches) {
    SampledSignal& one = series[static_cast<std::size_t>(touch)];
    const std::string name(name_of(touch));
    one = {.name = "p_" + name, .unit = "", .label = "Probability of " + name, .t_us = {}, .values = {}};
    for (std::size_t k = 0; k < run.probabilities.size(); ++k)
      add_sample(one, between(first, run.ticks.at(static_cast<std::int64_t>(k))).count(),
                 static_cast<double>(run.probabilities[k][static_cast<std::size_t>(touch)]));
  }
  return series;
}

}  // namespace tactile::review
