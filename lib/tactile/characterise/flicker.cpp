#include "tactile/characterise/flicker.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <span>
#include <unsupported/Eigen/FFT>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::characterise {
namespace {

constexpr double lowest_hz = 50, highest_hz = 2000;

double hann(std::int64_t i, std::int64_t length) {
  return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(length));
}

/// The amplitude that a Hann window leaves of a line `offset` bins from a frequency.
double hann_response(double offset) {
  const double x = std::numbers::pi * offset;
  const double sinc = std::abs(x) < 1e-9 ? 1 : std::sin(x) / x;
  return sinc / (1 - offset * offset);
}

/// A frequency of which lines are multiples, and how many more of its multiples have a line than lack one.
struct Fundamental {
  Measured hz;
  double lines_less_gaps = 0;
};

/// Follows the multiples of `hz` from line to line; each makes it more exact.
Fundamental followed(Measured hz, std::span<const FlickerLine> lines, double from_hz) {
  constexpr double deviations = 3;
  double found = 0, last = 0;
  for (const FlickerLine& line : lines) {
    const double n = std::nearbyint(line.hz.value / hz.value);
    const double uncertainty = std::max(1e-9, std::hypot(line.hz.uncertainty, n * hz.uncertainty));
    if (n <= last || std::abs(line.hz.value - n * hz.value) > deviations * uncertainty) continue;
    found += 1;
    last = n;
    const double weight = std::pow(n * hz.uncertainty / uncertainty, 2);
    hz.value += weight * (line.hz.value / n - hz.value);
    hz.uncertainty *= std::sqrt(1 - weight);
  }
  const double multiples = last - std::ceil(from_hz / hz.value) + 1;
  return {hz, found - (multiples - found)};
}

/// The frequency of the first line, or one below the searched range if more lines are multiples of it than multiples lack one.
Measured fundamental_of(std::span<const FlickerLine> lines, const Flicker& flicker) {
  const Measured first = lines.front().hz;
  Fundamental best = followed(first, lines, flicker.from_hz);
  best.hz = first;
  // Multiples closer than two resolutions would not be separate lines.
  for (int n = 2; first.value > 2 * flicker.resolution_hz * n; ++n) {
    const Measured hz{first.value / n, first.uncertainty / n};
    const Fundamental other = followed(hz, lines, flicker.from_hz);
    if (hz.value < flicker.from_hz && other.lines_less_gaps > best.lines_less_gaps) best = other;
  }
  return best.hz;
}

}  // namespace

double chance_of(double ratio, double n) {
  const double z = (std::cbrt(ratio) - (1 - 1 / (9 * n))) * std::sqrt(9 * n);
  return 0.5 * std::erfc(z / std::numbers::sqrt2);
}

std::vector<FlickerSeries> series_of(const Flicker& flicker) {
  std::vector<FlickerSeries> series;
  std::vector<FlickerLine> left = flicker.lines;
  while (!left.empty()) {
    FlickerLine line = left.front();
    const auto end = std::stable_partition(left.begin(), left.end(), [&](const auto& l) { return l.is_local == line.is_local; });
    line.hz = fundamental_of({left.begin(), end}, flicker);
    // Of lines closer than the resolution only one is found.
    const auto is_multiple = [&](const FlickerLine& other) {
      const double n = std::nearbyint(other.hz.value / line.hz.value);
      return other.is_local == line.is_local && std::abs(other.hz.value - n * line.hz.value) <= flicker.resolution_hz;
    };
    const auto found = static_cast<std::size_t>(std::count_if(left.begin(), left.end(), is_multiple));
    series.push_back({line, line.hz.value < left.front().hz.value ? found : found - 1});
    left.erase(std::remove_if(left.begin(), left.end(), is_multiple), left.end());
    std::sort(left.begin(), left.end(), [](const FlickerLine& a, const FlickerLine& b) { return a.hz.value < b.hz.value; });
  }
  return series;
}

FlickerMeter::FlickerMeter(double bin_us, double readout_us, microseconds duration) : bin_us_(bin_us), readout_us_(readout_us) {
  constexpr double longest_s = 1.0, segments = 8;
  constexpr std::int64_t fewest = 256;
  const double wanted = std::min(longest_s * 1e6, static_cast<double>(duration.count()) / segments) / bin_us;
  length_ = fewest;
  while (static_cast<double>(2 * length_) <= wanted) length_ *= 2;
  counts_.resize(static_cast<std::size_t>(length_));
  power_.resize(static_cast<std::size_t>(length_ / 2 + 1));
  squares_.resize(power_.size());
}

void FlickerMeter::begin_recording() {
  begin_ = 0;
  std::fill(counts_.begin(), counts_.end(), 0.0F);
}

void FlickerMeter::advance(std::int64_t index) {
  take_segment();
  const std::int64_t half = length_ / 2;
  begin_ += half;
  std::copy(counts_.begin() + half, counts_.end(), counts_.begin());
  std::fill(counts_.begin() + half, counts_.end(), 0.0F);
  if (index < begin_ + length_) return;
  take_segment();
  if (index < begin_ + length_ + half) {
    advance(index);
    return;
  }
  begin_ = index;  // a silence says nothing about flicker
  std::fill(counts_.begin(), counts_.end(), 0.0F);
}

void FlickerMeter::take_segment() {
  const double events = std::accumulate(counts_.begin(), counts_.end(), 0.0);
  if (events < 2) return;
  const double mean = events / static_cast<double>(length_);
  std::vector<float> windowed(counts_.size());
  for (std::size_t i = 0; i < counts_.size(); ++i)
    windowed[i] = static_cast<float>((static_cast<double>(counts_[i]) - mean) * hann(static_cast<std::int64_t>(i), length_));
  std::vector<std::complex<float>> spectrum;
  Eigen::FFT<float> fft;
  fft.SetFlag(Eigen::FFT<float>::HalfSpectrum);
  fft.fwd(spectrum, windowed);
  for (std::size_t i = 0; i < power_.size(); ++i) {
    const double power = static_cast<double>(std::norm(spectrum[i]));
    power_[i] += power;
    squares_[i] += power * power;
  }
  segments_ += 1;
  events_ += events;
}

bool FlickerMeter::belongs_to_readouts(double hz) const {
  constexpr int highest_multiple = 32;
  if (readout_us_ <= 0) return false;
  const double sampling_hz = 1e6 / bin_us_, resolution = sampling_hz / static_cast<double>(length_);
  for (int n = 1; n <= highest_multiple; ++n) {
    const double multiple = n * 1e6 / readout_us_;
    const double seen = std::abs(multiple - sampling_hz * std::nearbyint(multiple / sampling_hz));
    if (std::abs(hz - seen) <= 3 * resolution) return true;
  }
  return false;
}

FlickerLine FlickerMeter::line_at(std::size_t i, double floor, double chance) const {
  const double resolution = 1e6 / bin_us_ / static_cast<double>(length_);
  const double peak = power_[i] / segments_, below = power_[i - 1] / segments_, above = power_[i + 1] / segments_;
  const auto amplitude = [&](double power) { return std::sqrt(std::max(0.0, power - floor)); };
  // Of a Hann window the ratio of neighbours gives the place: r = (1 + d) / (2 - d) for the larger neighbour.
  const double larger = std::max(below, above), ratio = amplitude(larger) / std::max(1e-12, amplitude(peak));
  const double offset = std::clamp((2 * ratio - 1) / (1 + ratio), 0.0, 0.5) * (above > below ? 1 : -1);
  // Half of the segments are independent of each other; neighbours of a Hann window count about twice.
  const double independent = std::max(1.0, segments_ / 1.9);
  const double noise = std::sqrt(floor * (floor + 2 * std::max(0.0, peak - floor)) / independent);
  const double relative = noise / std::max(1e-12, 2 * (peak - floor));  // of the amplitude
  FlickerLine line;
  line.chance = chance;
  line.hz = {(static_cast<double>(i) + offset) * resolution, resolution * std::hypot(0.01, 1.5 * relative)};
  const double mean = events_ / segments_ / static_cast<double>(length_);
  const double smear = std::numbers::pi * line.hz.value * bin_us_ * 1e-6;  // a bin averages over its length
  const double gain = mean * static_cast<double>(length_) / 4 * hann_response(offset) * std::sin(smear) / smear;
  const double mean_square = squares_[i] / segments_;
  const double scatter = std::sqrt(std::max(0.0, mean_square - peak * peak) / independent) / (2 * std::max(1e-12, peak - floor));
  line.depth = {amplitude(peak) / gain, amplitude(peak) / gain * std::hypot(std::max(relative, scatter), 0.02)};
  return line;
}

Flicker FlickerMeter::flicker() const {
  constexpr double least_chance = 1e-3;
  constexpr std::size_t around = 24;
  Flicker flicker{.from_hz = lowest_hz, .to_hz = std::min(highest_hz, 0.5e6 / bin_us_), .lines = {}, .spectrum = {}};
  flicker.resolution_hz = 1e6 / bin_us_ / static_cast<double>(length_);
  if (segments_ < 1) {
    flicker.to_hz = 0;
    return flicker;
  }
  const auto first = std::max<std::size_t>(2, static_cast<std::size_t>(std::ceil(lowest_hz / flicker.resolution_hz)));
  const auto last = std::min(power_.size() - 3, static_cast<std::size_t>(flicker.to_hz / flicker.resolution_hz));
  flicker.spectrum.assign(power_.size(), 0);
  const double independent = std::max(1.0, segments_ / 1.9);
  const double median_share = std::pow(1 - 1 / (9 * independent), 3);  // of a mean of exponential values
  std::vector<double> floors(power_.size());
  for (std::size_t i = 1; i + 1 < power_.size(); ++i) {
    const std::size_t from = std::max<std::size_t>(1, i - std::min(i, around)), to = std::min(power_.size() - 2, i + around);
    floors[i] = median<double>(std::span(power_).subspan(from, to - from + 1)) / segments_ / median_share;
    flicker.spectrum[i] = floors[i] > 0 ? power_[i] / segments_ / floors[i] : 0;
  }
  const auto searched = static_cast<double>(last - std::min(first, last) + 1);
  const std::vector<double>& ratios = flicker.spectrum;
  for (std::size_t i = first; i <= last; ++i) {
    if (ratios[i] < ratios[i - 1] || ratios[i] <= ratios[i + 1]) continue;
    if (ratios[i] < ratios[i - 2] || ratios[i] < ratios[i + 2]) continue;  // beside a stronger line
    const double chance = std::min(1.0, chance_of(ratios[i], independent) * searched);
    if (chance >= least_chance || belongs_to_readouts(static_cast<double>(i) * flicker.resolution_hz)) continue;
    flicker.lines.push_back(line_at(i, floors[i], chance));
  }
  return flicker;
}

}  // namespace tactile::characterise
