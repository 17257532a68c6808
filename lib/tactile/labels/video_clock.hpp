#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/labels/clock_fit.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/robot/arm_motion.hpp"
#include "tactile/video/motion_energy.hpp"

namespace tactile {

/// What a film of the run must have seen move, and how fast, in camera time: the arm by its log, or the skin by its events.
struct SeenMotion {
  CameraTime begin{};
  microseconds step{4'000};   ///< > 0
  std::vector<double> speed;  ///< at begin + i * step, in any unit, >= 0; straight lines in between, nothing known beyond
  double sigma_us = 0;        ///< standard deviation of its place in camera time, all of it together, >= 0
};

/// The arm's, through its clock; what is within five standard deviations of the noise of a resting arm is 0.
SeenMotion seen_motion(const ArmMotion& motion, const FittedClock& robot_clock);

struct VideoClockOptions {
  std::optional<std::int64_t> coarse_offset_us = {};  ///< where it is known: camera time of the film's first frame less its own
  microseconds search{5'000'000};                     ///< round that, else everywhere where the two overlap
  double least_likeness = 0.8;                        ///< refused below: correlation of energy and speed where they match best
  double least_ambiguity = 1.5;                       ///< refused below: best likeness over that of the next best place
  double most_disagreement_us = 60'000;               ///< refused if start and stop of a motion place the film further apart
};

/// The video's clock, or why it could not be found.
struct VideoClockFit {
  std::optional<FittedClock> clock;
  std::string refused;               ///< in words, empty if there is a clock
  double likeness = 0;               ///< at the best place, -1 to 1
  double ambiguity = 0;              ///< best likeness over the next best; 99 where there is no other
  std::vector<ClockAnchor> anchors;  ///< the middle of each motion, or its start or end
};

/// Relates a film's clock to the camera's by what moves in both.
///
/// 1. The likeness of the film's energy and the speed it should have seen, at every offset: their correlation over the steps from
///    frame to frame, each step with the mean of the speed over its length, less where much of either lies beyond the other's
///    end. First in steps of half a frame (longer films: of up to a 4096th of the film), then around the best of them to a
///    millisecond and by a parabola.
/// 2. Around each start and stop of the motion, a x speed + c is fitted to the energies, and moved in time until it leaves least.
///    A film that sees slow motion less than in proportion sees starts late and stops early by the same time, so that their mean
///    is right. What they differ by tells how far the model can be trusted: half of it, and a 32nd of a frame with twice the
///    weight, are taken as the standard deviation of that mean. A start or stop alone has a 16th of a frame.
/// 3. `fit_clock` through the middles of the motions. One run's film allows no drift: it is 0, unless four motions over 60 s and
///    more allow a line.
///
/// @param energy  of the run's film
/// @param seen    of the same run; what else moves in the film does not matter as long as it moves less or for another time
VideoClockFit fit_video_clock(const MotionEnergy& energy, const SeenMotion& seen, const VideoClockOptions& options = {});

/// A stretch in which the skin fires: a motion that touches or drags it.
struct SeenBurst {
  CameraTime start{}, end{};
};

/// Likewise from the events alone, less well: a motion that the film shows ends when a burst does, and starts with it or before
/// it (a stage moves before it touches). The offset at which most do, and best, is taken. Slack, ringing and slow ends move a
/// burst against the film's motion, so that each has a standard deviation of 15 ms beside the film's own, and all together one of
/// 10 ms.
VideoClockFit fit_video_clock(const MotionEnergy& energy, std::span<const SeenBurst> bursts,
                              const VideoClockOptions& options = {});

/// A stretch of motion in a film, in camera time; each end with its 95 % interval, the clock's included.
struct VideoMotion {
  UncertainTime start, end;
  double energy = 0;       ///< mean [grey levels/s]
  bool start_cut = false;  ///< it moves in the film's first frames: it may have started at any time before
  bool end_cut = false;    ///< likewise in its last
  bool faint = false;      ///< hardly to be seen: it may have begun long before and gone on long after
};

/// All of them, by time: from a step of ten standard deviations of the film's noise out to where less than two and a half are
/// left, over up to 80 ms that show nothing, and without the steps at either end that have less than 3 % of its usual energy. A
/// start is that of an even rise to the usual speed, the one that fits best; its interval holds what fits nearly as well, and the
/// time in which the motion is too slow to be seen. Ends likewise.
std::vector<VideoMotion> video_motions(const MotionEnergy& energy, const FittedClock& clock);

/// The start (or end) of motion in the film nearest to `t`, if the intervals of both come within `apart` of each other; no cut
/// ones.
std::optional<UncertainTime> video_start_near(std::span<const VideoMotion> motions, const UncertainTime& t, microseconds apart);
std::optional<UncertainTime> video_end_near(std::span<const VideoMotion> motions, const UncertainTime& t, microseconds apart);

/// Whether anything moved in the film in [begin, end) of camera time; nothing if it does not show all of that: frames that are
/// missing for four frames' time or more included.
std::optional<bool> video_saw_motion(const MotionEnergy& energy, const FittedClock& clock, CameraTime begin, CameraTime end);

}  // namespace tactile
