#include "tactile/video/frame_clock.hpp"

#include <algorithm>
#include <cmath>

namespace tactile::video {
namespace {

constexpr microseconds ahead_of_host = 5s;
constexpr microseconds longest_step = 1h;
constexpr double new_beginning_us = -1e6;

}  // namespace

std::optional<microseconds> FrameClock::time_of(double source_ms, HostTime arrived) {
  if (!begun_) {
    begun_ = true;
    source_ms_ = source_ms;
    arrived_ = arrived;
    return t_;
  }
  // Beyond a day or so a step is damage anyway, and the conversion must not overflow.
  const double source_step_us = std::round(1000.0 * (source_ms - source_ms_));
  const bool is_step = std::isfinite(source_step_us) && std::abs(source_step_us) < 1e11;
  const microseconds source_step{is_step ? static_cast<std::int64_t>(source_step_us) : 0};
  const microseconds came_step = std::max(arrived - arrived_, microseconds{1});
  const bool ascends = std::isfinite(source_step_us) && source_step_us >= 1;

  microseconds step = source_step;
  if (live_) {
    if (!ascends || !is_step || source_step > came_step + ahead_of_host) step = came_step;
  } else if (source_step_us < new_beginning_us) {
    step = frame_;
  } else if (!ascends) {
    if (ascended_ || ++standing_ < 2)
      return std::nullopt;  // `source_ms_` stays: what follows is measured from the last with a place
    step = frame_;
  } else {
    ascended_ = true;
    if (!is_step || source_step > longest_step) step = frame_;
  }
  own_ = step == source_step;
  source_ms_ = source_ms;
  arrived_ = arrived;
  return t_ += step;
}

}  // namespace tactile::video
