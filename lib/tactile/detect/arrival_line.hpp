#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile {

/// When what happens in camera time is on the host at the earliest: a line that lies below the arrivals of the last ten seconds.
///
///   host - host_0 = (1 + drift) * (camera - camera_0) + offset
///
/// An element may come late and never early, so no arrival lies below the line, and of all such lines it is the one whose delays
/// are the least in sum. Drift is 0 until two seconds are known, and within 200 ppm then, as of two quartz clocks. Asks for no
/// memory after the first ten seconds.
class ArrivalLine {
 public:
  ArrivalLine() { lowest_.reserve(most_points + 1), hull_.reserve(most_points + 1); }

  /// @param newest   of the elements that arrived together
  /// @param arrived  ascending from call to call
  void add(CameraTime newest, HostTime arrived);

  bool is_known() const { return known_; }
  double drift_ppm() const { return 1e6 * drift_; }

  // Both held at the ends of their clocks; once it is known.
  HostTime host_of(CameraTime t) const;
  CameraTime camera_of(HostTime t) const;  ///< the inverse, to the microsecond or so

  void restart() { known_ = false, lowest_.clear(), drift_ = offset_ = 0; }

 private:
  static constexpr std::size_t most_points = 100;
  /// The arrival with the least delay of a tenth of a second.
  struct Point {
    std::int64_t period;   ///< tenths of a second since the first arrival
    double camera, delay;  ///< [us] since the first; delay against it
  };
  void fit();

  bool known_ = false;
  CameraTime camera_begin_{};
  HostTime host_begin_{};
  std::vector<Point> lowest_;  ///< ascending
  std::vector<Point> hull_;    ///< of them, while a line is fitted
  double drift_ = 0, offset_ = 0;
};

}  // namespace tactile
