#pragma once

#include <span>
#include <vector>

#include "tactile/labels/posterior/clock_offsets.hpp"

namespace tactile::labels {

/// What a run alone says of the robot's clock.
struct OffsetsOfRun {
  RobotTime at{};                      ///< the middle of its log
  std::vector<WeighedOffset> offsets;  ///< empty: nothing
};

/// What the other runs of a session say of each run's offset; nothing where no other run has a log. Runs share a line
///
///   offset(t) = offset + drift t,   drift ~ N(0, 60 ppm)
///
/// and each has, with a probability of 5 %, another one, since a controller may restart. The twelve runs nearest in time count.
std::vector<std::vector<WeighedOffset>> offsets_by_others(std::span<const OffsetsOfRun> runs);

}  // namespace tactile::labels
