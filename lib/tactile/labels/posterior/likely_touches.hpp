#pragma once

#include <vector>

#include "tactile/alignment/fitted_clock.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/labels/posterior/drawn_paths.hpp"

namespace tactile::labels {

/// A touch that may have happened.
struct LikelyTouch {
  Touch touch = Touch::none;
  double probability = 0;               ///< that it did, and is of this class
  alignment::UncertainTime start, end;  ///< medians and 95 % intervals, if it did
};

/// The touches of at least a twentieth of the paths, by start. Those of one class that begin within 100 ms are one. Slips with
/// less than 150 ms between them are one slip that sticks.
std::vector<LikelyTouch> likely_touches(const PathSample& sample);

/// The releases that are more likely than not, by start.
std::vector<TouchInterval> likely_releases(const PathSample& sample);

}  // namespace tactile::labels
