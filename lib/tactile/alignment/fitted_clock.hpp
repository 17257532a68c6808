#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "tactile/core/clock_relation.hpp"

namespace tactile::alignment {

constexpr double normal_95 = 1.96;  ///< half of a 95 % interval, in standard deviations

/// A time and its 95 % interval.
struct UncertainTime {
  CameraTime at{};
  CameraTime low{};
  CameraTime high{};
};

/// A clock as it was found, and how well.
struct FittedClock {
  ClockRelation relation;
  std::int64_t offset_low_us = 0;  ///< 95 % interval of `relation.offset_us`; the robot's in the run's middle, the film's at
                                   ///< `found_at_us`
  std::int64_t offset_high_us = 0;
  std::int64_t found_at_us = 0;  ///< on the film's clock: where the offset is known best
  double drift_within_ppm = 0;   ///< half of the 95 % interval of the film's drift, which counts from `found_at_us` on
  int anchors = 0;
  std::string method;
  std::optional<CameraTime> from = {}, to = {};  ///< where it holds, of a clock that restarts within the run

  /// How far the offset may be off, to either side, >= 0.
  microseconds uncertainty() const {
    return microseconds{std::max({saturating_subtract(relation.offset_us, offset_low_us),
                                  saturating_subtract(offset_high_us, relation.offset_us), std::int64_t{0}})};
  }

  /// The same at a time, with the drift since `found_at_us`.
  microseconds uncertainty_at(CameraTime t) const {
    const auto since_us = static_cast<double>(saturating_subtract(relation.clock_us_from(t), found_at_us));
    return microseconds{std::llround(std::hypot(static_cast<double>(uncertainty().count()), 1e-6 * drift_within_ppm * since_us))};
  }
};

}  // namespace tactile::alignment
