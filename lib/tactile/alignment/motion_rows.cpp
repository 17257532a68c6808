#include "tactile/alignment/motion_rows.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/infinite.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::alignment {
namespace {

constexpr double chi3_median = 1.538;  // of the length of three noisy components, in their standard deviations
constexpr double noise_factor = 5.0;   // above that median
constexpr double longest_pause_s = 0.06;
constexpr double rest_before_s = 0.15;
constexpr double ringing_share = 0.1;  // of the peak speed: a fit may leave so much of a ringing
constexpr double ringing_lasts_s = 0.3;

}  // namespace

double speed_noise(const robot::RobotLog& log) {
  constexpr microseconds apart{24'000}, too_far{60'000};
  std::vector<double> differences;
  std::size_t j = 0;
  for (const robot::RobotState& state : log.states) {
    while (j < log.states.size() && log.states[j].t - state.t < apart) ++j;
    if (j == log.states.size()) break;
    if (log.states[j].t - state.t > too_far) continue;
    const robot::RobotState& later = log.states[j];
    differences.push_back(std::hypot(later.tcp_speed[0] - state.tcp_speed[0], later.tcp_speed[1] - state.tcp_speed[1],
                                     later.tcp_speed[2] - state.tcp_speed[2]));
  }
  if (differences.size() < 8) return 0.0;
  return median(differences) / (chi3_median * std::sqrt(2.0));
}

MotionRows::MotionRows(const robot::RobotLog& log, double slowest) : noise_(std::max(speed_noise(log), 1e-6)) {
  const RobotTime first = log.states.front().t;
  rows_.reserve(log.states.size());
  for (const robot::RobotState& state : log.states) {
    rows_.push_back({.t_s = 1e-6 * static_cast<double>((state.t - first).count()),
                     .speed = {state.tcp_speed[0], state.tcp_speed[1], state.tcp_speed[2]}});
  }
  limit_ = std::max(slowest, (chi3_median + noise_factor) * noise_);
  if (const double rate = robot::rate_hz(log); rate > 0) period_s_ = 1.0 / rate;
}

double MotionRows::speed(std::size_t row) const { return length_of(rows_[row].speed); }

bool MotionRows::moves(std::size_t row) const {
  return speed(row) >= (rows_[row].t_s < ringing_until_s_ ? std::max(limit_, ringing_limit_) : limit_);
}

std::size_t MotionRows::row_at_or_after(double t_s) const {
  const auto found = std::partition_point(rows_.begin(), rows_.end(), [&](const SpeedRow& row) { return row.t_s < t_s; });
  return static_cast<std::size_t>(found - rows_.begin());
}

std::size_t MotionRows::stretch_end(std::size_t begin) const {
  const double longest_s = std::max(longest_pause_s, 2.5 * period_s_);
  std::size_t end = begin + 1;
  for (std::size_t i = end; i < rows_.size() && !gap_before(i); ++i) {
    if (moves(i)) {
      end = i + 1;
    } else if (rows_[i].t_s - rows_[end - 1].t_s > longest_s) {
      break;
    }
  }
  return end;
}

double MotionRows::rest_begin_s(std::size_t row) const {
  std::size_t i = row;
  while (i > 0 && !gap_before(i) && rows_[row].t_s - rows_[i - 1].t_s <= rest_before_s && rows_[i - 1].t_s > explained_until_s_)
    --i;
  return rows_[i].t_s;
}

double MotionRows::tail_end_s(std::size_t end, double least_m, double tail_s) const {
  const double until_s = rows_[end - 1].t_s + tail_s;
  double moved_m = 0, since_s = infinite;
  for (std::size_t i = end; i < rows_.size(); ++i) {
    if (gap_before(i)) return std::min(rows_[i].t_s, until_s);
    if (moves(i)) {
      since_s = std::min(since_s, rows_[i].t_s);
      moved_m += speed(i) * (rows_[i].t_s - rows_[i - 1].t_s);
      if (moved_m > least_m) return std::min(until_s, std::max(since_s - 0.02, rows_[end].t_s));
    } else {
      moved_m = 0;
      since_s = infinite;
      if (rows_[i].t_s > until_s) break;
    }
  }
  return until_s;
}

void MotionRows::subtract(const SpeedProfile& profile, double stop_s, double peak_speed) {
  const double faded_s = stop_s + 12.0 * profile.ringing.decay_s;
  for (std::size_t i = row_at_or_after(profile.knots_s.front()); i < rows_.size() && rows_[i].t_s <= faded_s; ++i) {
    const SpeedProfile::Speed commanded = profile.commanded_at(rows_[i].t_s), ringing = profile.ringing_at(rows_[i].t_s);
    for (std::size_t a = 0; a < 3; ++a) rows_[i].speed[a] -= commanded[a] + ringing[a];
  }
  ringing_until_s_ = stop_s + ringing_lasts_s;
  ringing_limit_ = ringing_share * peak_speed;
}

}  // namespace tactile::alignment
