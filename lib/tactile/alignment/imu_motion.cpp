#include "tactile/alignment/imu_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::alignment {
namespace {

constexpr double median_over_s = 2.0, median_every_s = 0.5;

/// Medians of one axis over `median_over_s`, at every `median_every_s`, and the time of each.
struct Medians {
  std::vector<double> at_s, value;

  double value_at(double t_s) const {
    const auto above = std::upper_bound(at_s.begin(), at_s.end(), t_s);
    if (above == at_s.begin()) return value.front();
    if (above == at_s.end()) return value.back();
    const auto i = static_cast<std::size_t>(above - at_s.begin());
    const double share = (t_s - at_s[i - 1]) / (at_s[i] - at_s[i - 1]);
    return (1.0 - share) * value[i - 1] + share * value[i];
  }
};

Medians medians_of(const std::vector<double>& t_s, const std::vector<Vector3>& samples, std::size_t axis) {
  Medians medians;
  std::vector<double> values;
  std::size_t begin = 0, end = 0;
  const auto step_of = [](double t) { return static_cast<std::int64_t>(std::floor(t / median_every_s)); };
  for (std::int64_t step = 0; step <= step_of(t_s.back()) + 1; ++step) {
    const double at = median_every_s * static_cast<double>(step);
    // At the ends the window is as long as elsewhere: a motion there must not fill it.
    const double from = std::clamp(at - 0.5 * median_over_s, 0.0, std::max(0.0, t_s.back() - median_over_s));
    while (begin < t_s.size() && t_s[begin] < from) ++begin;
    end = std::max(end, begin);
    while (end < t_s.size() && t_s[end] <= from + median_over_s) ++end;
    if (begin == end) {  // a gap: continue at the next sample, since a recording may lack hours
      if (begin == t_s.size()) break;
      step = std::max(step, step_of(t_s[begin]) - 1);
      continue;
    }
    values.clear();
    for (std::size_t i = begin; i < end; ++i) values.push_back(samples[i][axis]);
    medians.at_s.push_back(at);
    medians.value.push_back(median(values));
  }
  return medians;
}

}  // namespace

ImuMotion imu_motion(std::span<const events::ImuSample> samples) {
  ImuMotion motion;
  std::vector<double> t_s;
  for (const events::ImuSample& sample : samples) {
    const bool finite = std::all_of(std::begin(sample.acceleration_g), std::end(sample.acceleration_g),
                                    [](float value) { return std::isfinite(value); });
    if (!finite || (!motion.t.empty() && sample.t <= motion.t.back())) continue;
    motion.t.push_back(sample.t);
    t_s.push_back(motion.seconds(motion.t.size() - 1));
    Vector3 acceleration;
    for (std::size_t k = 0; k < 3; ++k)
      acceleration[k] = events::standard_gravity * static_cast<double>(sample.acceleration_g[k]);
    motion.acceleration.push_back(acceleration);
  }
  if (motion.t.empty()) return motion;
  const std::size_t n = motion.t.size();

  std::vector<double> sizes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Medians medians = medians_of(t_s, motion.acceleration, axis);
    for (std::size_t i = 0; i < n; ++i) motion.acceleration[i][axis] -= medians.value_at(t_s[i]);
    for (std::size_t i = 0; i < n; ++i) sizes.push_back(std::abs(motion.acceleration[i][axis]));
  }
  motion.noise_m_s2 = sigma_per_median * median(sizes);
  return motion;
}

}  // namespace tactile::alignment
