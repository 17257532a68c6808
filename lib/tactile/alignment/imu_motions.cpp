#include "tactile/alignment/imu_motions.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/alignment/imu_motion.hpp"
#include "tactile/alignment/moving_mean.hpp"

namespace tactile::alignment {
namespace {

constexpr double smoothed_s = 0.04, apart_s = 0.08;
constexpr double least_m_s2 = 0.08, least_m_s = 0.01;  // of a push
constexpr microseconds longest_move = 10s;

/// A stretch in which the camera speeds up or brakes.
struct Push {
  std::size_t begin = 0, end = 0;  ///< samples
  Vector3 gained{};                ///< [m/s]
};

std::vector<Push> pushes_in(const ImuMotion& motion) {
  const std::size_t n = motion.t.size();
  const double step_s = motion.seconds(n - 1) / static_cast<double>(n - 1);
  if (!(step_s > 0)) return {};
  const auto samples = [&](double span_s) { return static_cast<std::size_t>(std::max(1.0, span_s / step_s)); };
  const std::size_t width = samples(smoothed_s);
  std::vector<std::vector<double>> axes(3, std::vector<double>(n));
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < n; ++i) axes[k][i] = motion.acceleration[i][k];
    axes[k] = moving_mean(axes[k], width);
  }
  const double limit = std::max(least_m_s2, 6.0 * motion.noise_m_s2 / std::sqrt(static_cast<double>(width)));
  std::vector<Push> pushes;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3 a{axes[0][i], axes[1][i], axes[2][i]};
    if (length_of(a) < limit) continue;
    // A push has one direction. Acceleration in the opposite direction is the next push.
    const bool continues = !pushes.empty() && i <= pushes.back().end + samples(apart_s) && dot(a, pushes.back().gained) > 0;
    if (!continues) pushes.push_back({.begin = i, .end = i});
    pushes.back().end = i + 1;
    for (std::size_t k = 0; k < 3; ++k) pushes.back().gained[k] += step_s * a[k];
  }
  std::erase_if(pushes, [](const Push& push) { return length_of(push.gained) < least_m_s; });
  return pushes;
}

/// Whether the second push takes off what the first gave.
bool stops(const Push& start, const Push& stop) {
  const double a = length_of(start.gained), b = length_of(stop.gained);
  return b > 0.6 * a && a > 0.6 * b && dot(start.gained, stop.gained) < -0.8 * a * b;
}

}  // namespace

std::vector<CameraSpan> imu_motions(std::span<const events::ImuSample> samples) {
  const ImuMotion motion = imu_motion(samples);
  if (motion.t.size() < 50) return {};
  const std::vector<Push> pushes = pushes_in(motion);
  std::vector<CameraSpan> moves;
  for (std::size_t i = 0; i + 1 < pushes.size(); ++i) {
    const auto stop = std::find_if(pushes.begin() + static_cast<std::ptrdiff_t>(i) + 1, pushes.end(),
                                   [&](const Push& later) { return stops(pushes[i], later); });
    if (stop == pushes.end()) continue;
    const CameraSpan move{.begin = motion.t[pushes[i].begin], .end = motion.t[stop->end - 1]};
    if (between(move.begin, move.end) > longest_move) continue;
    moves.push_back(move);
    i = static_cast<std::size_t>(stop - pushes.begin());
  }
  return moves;
}

}  // namespace tactile::alignment
