#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "tactile/alignment/motion_rows.hpp"

namespace tactile::alignment {

/// Rows in which the arm moves in one direction.
struct MotionLobe {
  std::size_t begin = 0, end = 0;  ///< the rows, [begin, end)
  double displacement_m = 0;       ///< along the stretch's direction; negative against it
};

/// The direction of the fastest of the rows [begin, end): a unit vector.
SpeedProfile::Speed direction_in(const MotionRows& rows, std::size_t begin, std::size_t end);

constexpr double least_lobe_share = 0.25;  ///< of the farthest lobe: the ringing after a motion goes less far

/// The lobes of a stretch of motion. Those that go less far than `least_lobe_share` of the farthest are left out.
std::vector<MotionLobe> lobes_in(const MotionRows& rows, std::size_t begin, std::size_t end,
                                 const SpeedProfile::Speed& direction);

/// The shortest rest between two lobes that counts as one [s].
double least_dwell_s(const MotionRows& rows);

/// Roughly where a lobe's speed leaves zero, reaches its height, leaves its height, and is back at zero.
struct LobeCorners {
  double start_s = 0, up_s = 0, down_s = 0, end_s = 0;
  double height = 0;  ///< [m/s]
};
LobeCorners corners_of(const MotionRows& rows, const MotionLobe& lobe);

/// A time in seconds of the log, and its standard deviation.
struct UncertainSeconds {
  double t_s = 0;
  double sigma_s = std::numeric_limits<double>::infinity();
};

/// Where a lobe starts (or ends): where a line through its speeds between a tenth and six tenths of their height is zero.
UncertainSeconds lobe_edge(const MotionRows& rows, const MotionLobe& lobe, bool is_start);

}  // namespace tactile::alignment
