#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::detect {

/// The earliest host time for each camera time: a line below the arrivals of the last ten seconds.
///
///   host - host_0 = (1 + drift) * (camera - camera_0) + offset
///
/// An element can arrive late, but never early. Therefore no arrival lies below the line, and of all such lines it has the least
/// sum of delays. Drift is 0 until two seconds are known, and then within 200 ppm, as of two quartz clocks. No memory is
/// allocated after the first ten seconds.
class ArrivalLine {
 public:
  ArrivalLine() { lowest_.reserve(most_points + 1), hull_.reserve(most_points + 1); }

  /// @param newest   of the elements that arrived together
  /// @param arrived  ascending from call to call
  void add(CameraTime newest, HostTime arrived);

  bool is_known() const { return known_; }
  double drift_ppm() const { return 1e6 * drift_; }

  // Limited to the range of their clocks; only once the line is known.
  HostTime host_of(CameraTime t) const;
  CameraTime camera_of(HostTime t) const;  ///< the inverse, within about a microsecond

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
  std::vector<Point> hull_;    ///< lower hull of `lowest_`, while a line is fitted
  double drift_ = 0, offset_ = 0;
};

}  // namespace tactile::detect
