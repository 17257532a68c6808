#pragma once

#include <chrono>
#include <optional>

#include "tactile/core/time.hpp"

namespace tactile {

/// When what happened in camera time is due on the host: the first instant at once, every other as much later as it lies behind
/// it, over `speed`. One that is late is due at once; the ones after it are not put off.
class Pace {
 public:
  /// @param speed  1 real time, 0 everything at once. @throws Error if it is negative or no number
  explicit Pace(double speed);

  bool has_begun() const { return begun_.has_value(); }
  void begin(CameraTime first);  ///< `first` is due now
  void reset() { begun_.reset(); }

  /// Waits until `t` is due, at most `patience`; false if it is not due by then.
  bool wait_for(CameraTime t, std::chrono::microseconds patience) const;

 private:
  double speed_;
  CameraTime first_{};
  std::optional<std::chrono::steady_clock::time_point> begun_;
};

}  // namespace tactile
