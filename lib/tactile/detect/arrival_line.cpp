#include "tactile/detect/arrival_line.hpp"

#include <algorithm>
#include <cmath>

namespace tactile::detect {
namespace {

constexpr std::int64_t period_us = 100'000;
constexpr double least_span_us = 2e6, most_drift = 200e-6;

/// `begin + us`, rounded and held at the ends of int64.
std::int64_t moved(std::int64_t begin, double us) {
  constexpr double limit = 9.2e18;
  return saturating_add(begin, std::llround(std::clamp(us, -limit, limit)));
}

double elapsed(std::int64_t from, std::int64_t to) { return static_cast<double>(saturating_subtract(to, from)); }

}  // namespace

void ArrivalLine::add(CameraTime newest, HostTime arrived) {
  if (!known_) {
    known_ = true;
    camera_begin_ = newest;
    host_begin_ = arrived;
  }
  const double camera = elapsed(us_of(camera_begin_), us_of(newest));
  const double host = elapsed(us_of(host_begin_), us_of(arrived));
  const Point point{saturating_subtract(us_of(arrived), us_of(host_begin_)) / period_us, camera, host - camera};
  const bool begins_period = lowest_.empty() || lowest_.back().period != point.period;
  if (begins_period) {
    lowest_.push_back(point);
  } else if (point.delay - drift_ * point.camera < lowest_.back().delay - drift_ * lowest_.back().camera) {
    lowest_.back() = point;
  } else {
    return;
  }
  const auto is_old = [&](const Point& old) { return old.period + static_cast<std::int64_t>(most_points) <= point.period; };
  lowest_.erase(lowest_.begin(), std::find_if_not(lowest_.begin(), lowest_.end(), is_old));
  if (begins_period) fit();
  offset_ = std::min(offset_, point.delay - drift_ * point.camera);
}

/// The edge of the points' lower hull over their mean place has the least sum of delays.
void ArrivalLine::fit() {
  drift_ = 0;
  if (lowest_.back().camera - lowest_.front().camera >= least_span_us) {
    double mean = 0;
    hull_.clear();
    for (const Point& point : lowest_) {
      mean += point.camera / static_cast<double>(lowest_.size());
      const auto turns_up = [&] {
        const Point &a = hull_[hull_.size() - 2], &b = hull_.back();
        return (b.camera - a.camera) * (point.delay - a.delay) > (b.delay - a.delay) * (point.camera - a.camera);
      };
      while (hull_.size() >= 2 && !turns_up()) hull_.pop_back();
      hull_.push_back(point);
    }
    for (std::size_t i = 0; i + 1 < hull_.size(); ++i) {
      const Point &a = hull_[i], &b = hull_[i + 1];
      if (a.camera <= mean && mean <= b.camera && b.camera > a.camera)
        drift_ = std::clamp((b.delay - a.delay) / (b.camera - a.camera), -most_drift, most_drift);
    }
  }
  offset_ = lowest_.front().delay - drift_ * lowest_.front().camera;
  for (const Point& point : lowest_) offset_ = std::min(offset_, point.delay - drift_ * point.camera);
}

HostTime ArrivalLine::host_of(CameraTime t) const {
  const double camera = elapsed(us_of(camera_begin_), us_of(t));
  const std::int64_t plain = saturating_add(us_of(host_begin_), saturating_subtract(us_of(t), us_of(camera_begin_)));
  return HostTime{microseconds{moved(plain, drift_ * camera + offset_)}};
}

CameraTime ArrivalLine::camera_of(HostTime t) const {
  const double host = elapsed(us_of(host_begin_), us_of(t)) - offset_;
  const std::int64_t plain = saturating_add(us_of(camera_begin_), saturating_subtract(us_of(t), us_of(host_begin_)));
  return camera_time(moved(plain, -offset_ - host * drift_ / (1 + drift_)));
}

}  // namespace tactile::detect
