#include "tactile/robot/motion_phases.hpp"

#include <algorithm>
#include <cmath>

namespace tactile {
namespace {

double speed_of(const RobotState& state) { return std::hypot(state.tcp_speed[0], state.tcp_speed[1], state.tcp_speed[2]); }

/// The speed that noise alone does not reach: five times the spread of a resting arm, which is how it mostly is.
double noise_limit(const std::vector<double>& speeds) {
  std::vector<double> sorted = speeds;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  // The magnitude of three noisy components has a median of 1.54 of their standard deviations.
  return *middle * (1.54 + 5.0) / 1.54;
}

/// Where the least-squares line through the rows with a speed between a tenth and six tenths of the peak meets zero. `from` is
/// the resting row beside the ramp, `towards_peak` is 1 for a rise and -1 for a fall.
RobotTime zero_of_ramp(const RobotLog& log, const std::vector<double>& speeds, std::ptrdiff_t from, std::ptrdiff_t towards_peak,
                       double peak) {
  const auto origin = log.states[static_cast<std::size_t>(from)].t;
  double n = 0, t_sum = 0, v_sum = 0, tt_sum = 0, tv_sum = 0;
  const auto rows = static_cast<std::ptrdiff_t>(speeds.size());
  for (std::ptrdiff_t i = from; i >= 0 && i < rows; i += towards_peak) {
    const double v = speeds[static_cast<std::size_t>(i)];
    if (v > 0.6 * peak) break;
    if (v < 0.1 * peak) continue;
    const double t = static_cast<double>((log.states[static_cast<std::size_t>(i)].t - origin).count());
    n += 1;
    t_sum += t;
    v_sum += v;
    tt_sum += t * t;
    tv_sum += t * v;
  }
  const double slope = n < 2 ? 0.0 : (n * tv_sum - t_sum * v_sum) / (n * tt_sum - t_sum * t_sum);
  if (!std::isfinite(slope) || slope * static_cast<double>(towards_peak) <= 0) return origin;
  const double zero = (t_sum - v_sum / slope) / n;
  return origin + microseconds(std::llround(zero));
}

}  // namespace

std::vector<MotionPhase> motion_phases(const RobotLog& log, const MotionPhaseOptions& options) {
  std::vector<double> speeds;
  for (const RobotState& state : log.states) speeds.push_back(speed_of(state));
  if (speeds.empty()) return {};
  const double limit = std::max(options.slowest, noise_limit(speeds));

  std::vector<MotionPhase> phases;
  for (std::size_t i = 0; i < speeds.size();) {
    if (speeds[i] < limit) {
      ++i;
      continue;
    }
    const std::size_t begin = i;
    double peak = 0;
    for (; i < speeds.size() && speeds[i] >= limit; ++i) peak = std::max(peak, speeds[i]);
    const std::size_t rest_before = begin > 0 ? begin - 1 : begin;
    const std::size_t rest_after = std::min(i, speeds.size() - 1);
    if (log.states[rest_after].t - log.states[rest_before].t < options.shortest) continue;
    phases.push_back({.start = zero_of_ramp(log, speeds, static_cast<std::ptrdiff_t>(rest_before), 1, peak),
                      .end = zero_of_ramp(log, speeds, static_cast<std::ptrdiff_t>(rest_after), -1, peak),
                      .peak_speed = peak,
                      .height_change = log.states[rest_after].tcp_pose[2] - log.states[rest_before].tcp_pose[2]});
  }
  return phases;
}

}  // namespace tactile
