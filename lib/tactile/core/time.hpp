#pragma once

#include <chrono>
#include <cstdint>
#include <limits>

namespace tactile {

using std::chrono::microseconds;
using namespace std::chrono_literals;

/// Each device counts whole microseconds on a clock of its own; no two agree until they are aligned.
struct CameraClock {
  using duration = microseconds;
};
struct RobotClock {
  using duration = microseconds;
};
struct VideoClock {
  using duration = microseconds;
};
struct HostClock {
  using duration = microseconds;
};
using CameraTime = std::chrono::time_point<CameraClock, microseconds>;
using RobotTime = std::chrono::time_point<RobotClock, microseconds>;
using VideoTime = std::chrono::time_point<VideoClock, microseconds>;
using HostTime = std::chrono::time_point<HostClock, microseconds>;

/// `a + b`, held at the ends of int64 where the sum lies beyond them.
constexpr std::int64_t saturating_add(std::int64_t a, std::int64_t b) {
  std::int64_t sum = 0;
  if (!__builtin_add_overflow(a, b, &sum)) return sum;
  return b > 0 ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int64_t>::min();
}

/// `a - b`, held at the ends of int64 where the difference lies beyond them.
constexpr std::int64_t saturating_subtract(std::int64_t a, std::int64_t b) {
  std::int64_t difference = 0;
  if (!__builtin_sub_overflow(a, b, &difference)) return difference;
  return b < 0 ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int64_t>::min();
}

/// `t - d`, held at the ends of the clock: a recording may lie near the ends of int64.
constexpr CameraTime before(CameraTime t, microseconds d) {
  return CameraTime{microseconds{saturating_subtract(t.time_since_epoch().count(), d.count())}};
}

/// `t + d`, held at the ends of the clock.
constexpr CameraTime after(CameraTime t, microseconds d) {
  return CameraTime{microseconds{saturating_add(t.time_since_epoch().count(), d.count())}};
}

/// `end - begin`, held at the ends of int64.
constexpr microseconds between(CameraTime begin, CameraTime end) {
  return microseconds{saturating_subtract(end.time_since_epoch().count(), begin.time_since_epoch().count())};
}

constexpr CameraTime camera_time(std::int64_t us) { return CameraTime{microseconds{us}}; }

/// Whole microseconds of a time on its own clock, as files store it.
template <class Clock>
constexpr std::int64_t us_of(std::chrono::time_point<Clock, microseconds> t) {
  return t.time_since_epoch().count();
}

}  // namespace tactile
