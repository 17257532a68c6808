#include "tactile/robot/pose_speeds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/robot/rotation.hpp"

namespace tactile::robot {
namespace {

constexpr microseconds reach{8'500};   // 8 ms, however the stamps are rounded
constexpr std::size_t most_rows = 16;  // on either side, if they come faster than any controller sends them
constexpr microseconds longest_step{100'000};

/// The gradient at 0 of the parabola a + b t + c t^2 of least squares; of a line if all points lie on one side.
class GradientAtZero {
 public:
  void add(double t, const std::array<double, 6>& values) {
    const double tt = t * t;
    n_ += 1;
    t1_ += t;
    t2_ += tt;
    t3_ += tt * t;
    t4_ += tt * tt;
    before_ = before_ || t < 0;
    after_ = after_ || t > 0;
    for (std::size_t i = 0; i < 6; ++i) {
      y0_[i] += values[i];
      y1_[i] += t * values[i];
      y2_[i] += tt * values[i];
    }
  }

  bool is_parabola() const { return before_ && after_ && n_ >= 3; }

  std::array<double, 6> gradients() const {
    std::array<double, 6> gradients{};
    const double line = n_ * t2_ - t1_ * t1_;
    if (!(line > 0)) return gradients;
    // Determinants of the normal equations.
    const double all = n_ * (t2_ * t4_ - t3_ * t3_) - t1_ * (t1_ * t4_ - t2_ * t3_) + t2_ * (t1_ * t3_ - t2_ * t2_);
    for (std::size_t i = 0; i < 6; ++i) {
      const double for_b =
          n_ * (y1_[i] * t4_ - y2_[i] * t3_) - y0_[i] * (t1_ * t4_ - t2_ * t3_) + t2_ * (t1_ * y2_[i] - t2_ * y1_[i]);
      gradients[i] = is_parabola() && all > 0 ? for_b / all : (n_ * y1_[i] - t1_ * y0_[i]) / line;
    }
    return gradients;
  }

 private:
  double n_ = 0, t1_ = 0, t2_ = 0, t3_ = 0, t4_ = 0;
  bool before_ = false, after_ = false;
  std::array<double, 6> y0_{}, y1_{}, y2_{};
};

}  // namespace

void set_speeds_from_poses(std::vector<RobotState>& states) {
  for (std::size_t i = 0; i < states.size(); ++i) {
    std::size_t begin = i, end = i + 1;
    const auto step = [&](std::size_t row) { return states[row].t - states[row - 1].t; };
    while (begin > 0 && i - begin < most_rows && step(begin) <= longest_step &&
           (begin == i || states[i].t - states[begin - 1].t <= reach))
      --begin;
    while (end < states.size() && end - i <= most_rows && step(end) <= longest_step &&
           (end == i + 1 || states[end].t - states[i].t <= reach))
      ++end;
    GradientAtZero fit;
    const std::array<double, 6>& here = states[i].tcp_pose;
    const RotationVector turned{here[3], here[4], here[5]};
    for (std::size_t k = begin; k < end; ++k) {
      const std::array<double, 6>& pose = states[k].tcp_pose;
      std::array<double, 6> from_here{pose[0] - here[0], pose[1] - here[1], pose[2] - here[2]};
      if (k != i) {
        const RotationVector turn = turn_from_to(turned, RotationVector{pose[3], pose[4], pose[5]});
        std::copy(turn.begin(), turn.end(), from_here.begin() + 3);
      }
      // In units of the reach, so that rounding loses no power of it.
      fit.add(static_cast<double>((states[k].t - states[i].t).count()) / static_cast<double>(reach.count()), from_here);
    }
    states[i].tcp_speed = fit.gradients();
    for (double& speed : states[i].tcp_speed) speed *= 1e6 / static_cast<double>(reach.count());
  }
}

void set_poses_from_speeds(std::vector<RobotState>& states) {
  std::array<double, 6> pose{};
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (i > 0 && states[i].t - states[i - 1].t <= longest_step) {
      const double seconds = 1e-6 * static_cast<double>((states[i].t - states[i - 1].t).count());
      for (std::size_t k = 0; k < 3; ++k) pose[k] += 0.5 * seconds * (states[i].tcp_speed[k] + states[i - 1].tcp_speed[k]);
    }
    states[i].tcp_pose = pose;
  }
}

}  // namespace tactile::robot
