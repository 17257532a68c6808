#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "tactile/alignment/fitted_clock.hpp"
#include "tactile/alignment/motion_energy.hpp"

namespace tactile::alignment {

/// A step of a film, from frame to frame, in microseconds from any zero.
struct FilmStep {
  double begin = 0, end = 0;
  double energy = 0;

  double length() const { return end - begin; }
};

/// A time of the film and its 95 % interval.
struct VideoSpan {
  VideoTime low{}, at{}, high{};
};

/// A stretch of motion in a film, on the film's own clock.
struct FilmedMotion {
  VideoSpan start, end;
  double energy = 0;       ///< mean [grey levels/s]
  bool start_cut = false;  ///< it moves in the film's first frames: it may have started at any time before
  bool end_cut = false;    ///< it moves in the film's last frames: it may have ended at any time after
  bool faint = false;      ///< hardly visible: it may have begun long before and ended long after
};

/// The first `most` of them, by time. A stretch of motion has a step of ten standard deviations of the film's noise. It reaches
/// out to where less than two and a half are left, over up to 80 ms without motion. Steps at either end with less than 3 % of
/// its usual energy do not count. A start is that of the even rise to the usual speed that fits best. Its interval holds what
/// fits nearly as well, and the time in which the motion is too slow to be seen. The same for ends.
std::vector<FilmedMotion> filmed_motions(const MotionEnergy& energy, std::size_t most);

/// A stretch of motion in a film, in camera time; the intervals include the clock's.
struct VideoMotion {
  UncertainTime start, end;
  double energy = 0;
  bool start_cut = false, end_cut = false, faint = false;  ///< as in FilmedMotion
};

std::vector<VideoMotion> video_motions(const MotionEnergy& energy, const FittedClock& clock);

/// The start of motion in the film nearest to `t`, if the intervals of both come within `apart` of each other; no cut ones.
std::optional<UncertainTime> video_start_near(std::span<const VideoMotion> motions, const UncertainTime& t, microseconds apart);

/// The start of the motion in the film within which a touch begins, such as that of a stage; no cut ones.
std::optional<UncertainTime> video_start_around(std::span<const VideoMotion> motions, const UncertainTime& onset);

}  // namespace tactile::alignment
