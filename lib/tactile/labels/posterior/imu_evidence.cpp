#include "tactile/labels/posterior/imu_evidence.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tactile::labels {
namespace {

constexpr std::int64_t step_us = 4'000;
constexpr double independent_part = 0.05;
constexpr double farther = 2;  // the camera moves more than the arm where its mount rings; what moves still more is not the arm
constexpr double gravity = 9.81;  // [m/s^2]

bool less_in_size(double a, double b) { return std::abs(a) < std::abs(b); }

std::vector<double> along_main_direction(const std::vector<alignment::Vector3>& values) {
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const alignment::Vector3& v : values) {
    const Eigen::Vector3d one(v[0], v[1], v[2]);
    squares += one * one.transpose();
  }
  const Eigen::Vector3d direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(squares).eigenvectors().col(2);
  std::vector<double> along(values.size());
  std::transform(values.begin(), values.end(), along.begin(),
                 [&](const alignment::Vector3& v) { return direction.dot(Eigen::Vector3d(v[0], v[1], v[2])); });
  return along;
}

}  // namespace

ImuEvidence::ImuEvidence(std::span<const events::ImuSample> samples, const alignment::ArmMotion& arm)
    : arm_begin_us_(us_of(arm.begin) + arm.step.count() / 2),
      arm_step_us_(arm.step.count()),
      arm_(along_main_direction(arm.acceleration)) {
  constexpr std::size_t most = std::size_t{1} << 20U;
  if (samples.size() < 50) return;
  const std::int64_t first = us_of(samples.front().t), length = saturating_subtract(us_of(samples.back().t), first);
  const auto bins = static_cast<std::size_t>(length / step_us);
  if (bins < 20 || bins > most) return;
  begin_us_ = first + step_us / 2;
  independent_ = independent_part * static_cast<double>(bins);
  imu_.assign(bins, {});
  std::vector<double> counts(bins, 0.0);
  alignment::Vector3 mean{};
  for (const events::ImuSample& sample : samples) {
    const auto bin = static_cast<std::size_t>((us_of(sample.t) - first) / step_us);
    if (bin >= bins) continue;
    counts[bin] += 1;
    for (std::size_t k = 0; k < 3; ++k) imu_[bin][k] += sample.acceleration_g[k];
  }
  for (std::size_t bin = 0; bin < bins; ++bin) {
    for (std::size_t k = 0; k < 3; ++k) {
      imu_[bin][k] = counts[bin] > 0 ? imu_[bin][k] / counts[bin] : bin > 0 ? imu_[bin - 1][k] : 0;
      mean[k] += imu_[bin][k] / static_cast<double>(bins);
    }
  }
  const double most_g = farther * *std::max_element(arm_.begin(), arm_.end(), less_in_size) / gravity;
  for (alignment::Vector3& one : imu_) {
    for (std::size_t k = 0; k < 3; ++k) one[k] = std::clamp(one[k] - mean[k], -std::abs(most_g), std::abs(most_g));
  }
}

double ImuEvidence::of(std::int64_t offset_us) const {
  double arm_arm = 0, arm_sum = 0;
  Eigen::Vector3d imu_imu = Eigen::Vector3d::Zero(), imu_sum = Eigen::Vector3d::Zero(), arm_imu = Eigen::Vector3d::Zero();
  for (std::size_t bin = 0; bin < imu_.size(); ++bin) {
    const Eigen::Vector3d imu(imu_[bin][0], imu_[bin][1], imu_[bin][2]);
    imu_imu += imu.cwiseAbs2();
    imu_sum += imu;
    const std::int64_t since = begin_us_ + static_cast<std::int64_t>(bin) * step_us - offset_us - arm_begin_us_;
    if (since < 0) continue;
    const auto i = static_cast<std::size_t>(since / arm_step_us_);
    if (i + 1 >= arm_.size()) continue;
    const double share = static_cast<double>(since % arm_step_us_) / static_cast<double>(arm_step_us_);
    const double arm = (1 - share) * arm_[i] + share * arm_[i + 1];
    arm_arm += arm * arm;
    arm_imu += arm * imu;
    arm_sum += arm;
  }
  const auto n = static_cast<double>(imu_.size());
  arm_arm -= arm_sum * arm_sum / n;
  arm_imu -= arm_sum * imu_sum / n;
  imu_imu -= imu_sum.cwiseAbs2() / n;
  double log_p = 0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double both = arm_arm * imu_imu[axis];
    const double explained = both > 0 ? std::min(arm_imu[axis] * arm_imu[axis] / both, 0.9999) : 0;
    log_p -= 0.5 * independent_ * std::log1p(-explained);
  }
  return log_p;
}

}  // namespace tactile::labels
