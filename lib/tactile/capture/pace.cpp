#include "tactile/capture/pace.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "tactile/core/error.hpp"

namespace tactile::capture {

Pace::Pace(double speed) : speed_(speed) {
  if (!std::isfinite(speed) || speed < 0)
    throw Error(fmt::format("speed: {} is out of range; expected a factor above 0, or 0 for as fast as possible", speed));
}

void Pace::begin(CameraTime first) {
  first_ = first;
  begun_ = std::chrono::steady_clock::now();
}

bool Pace::wait_for(CameraTime t, std::chrono::microseconds patience) const {
  if (speed_ == 0 || !begun_) return true;
  // Limited to ten years, so that the sum cannot overflow: a recording can have any times.
  const double after_s = std::clamp(1e-6 * static_cast<double>(between(first_, t).count()) / speed_, 0.0, 3e8);
  const auto due =
      *begun_ + std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(after_s));
  const auto now = std::chrono::steady_clock::now();
  if (due > now + patience) {
    std::this_thread::sleep_for(patience);
    return false;
  }
  if (due > now) std::this_thread::sleep_until(due);
  return true;
}

}  // namespace tactile::capture
