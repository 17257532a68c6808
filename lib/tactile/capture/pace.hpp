#pragma once

#include <chrono>
#include <optional>

#include "tactile/core/time.hpp"

namespace tactile::capture {

/// The host time at which a camera time is due in a replay: the first one at once, every other later by its distance from the
/// first one, divided by `speed`. A late one is due at once, and does not delay those after it.
class Pace {
 public:
  /// @param speed  1: real time; 0: as fast as possible. @throws Error  if it is negative or not a number
  explicit Pace(double speed);

  bool has_begun() const { return begun_.has_value(); }
  void begin(CameraTime first);  ///< `first` is due now
  void reset() { begun_.reset(); }

  /// Waits until `t` is due, at most `patience`. @return  whether it is due
  bool wait_for(CameraTime t, std::chrono::microseconds patience) const;

 private:
  double speed_;
  CameraTime first_{};
  std::optional<std::chrono::steady_clock::time_point> begun_;
};

}  // namespace tactile::capture
