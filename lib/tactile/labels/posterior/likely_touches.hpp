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

/// Whether only one of the two happened, as far as is known: they begin within 100 ms of each other.
bool are_alternatives(const LikelyTouch& a, const LikelyTouch& b);
/// Whether a touch of any class is more likely than not there, and this is its likeliest class. @param touch  one of `all`
bool is_likeliest(const LikelyTouch& touch, const std::vector<LikelyTouch>& all);

/// The releases that are more likely than not, by start.
std::vector<TouchInterval> likely_releases(const PathSample& sample);

/// A stretch in which no touch moves the skin.
struct LikelyRest {
  CameraTime begin{}, end{};
  CameraTime calm_begin{}, calm_end{};     ///< its longest part in which nothing else moves it, such as a knock
  double let_go = 0;                       ///< probability that nothing touches the skin at some time in it
  bool is_first = false, is_last = false;  ///< it begins with the recording, or ends with it

  CameraTime middle() const { return after(calm_begin, between(calm_begin, calm_end) / 2); }
};

/// Where a press, a slip, a release or the shear of a firm lift is less likely than not, by time.
std::vector<LikelyRest> likely_rests(const PathSample& sample);

}  // namespace tactile::labels
