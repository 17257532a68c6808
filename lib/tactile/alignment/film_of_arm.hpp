#pragma once

#include <span>
#include <vector>

#include "tactile/alignment/arm_motion.hpp"
#include "tactile/alignment/camera_span.hpp"
#include "tactile/alignment/fitted_clock.hpp"
#include "tactile/alignment/video_clock.hpp"

namespace tactile::alignment {

/// What a film of the run must have seen move, and how fast, in camera time.
struct SeenMotion {
  CameraTime begin{};
  microseconds step{4'000};   ///< > 0
  std::vector<double> speed;  ///< at begin + i * step, in any unit, >= 0; straight lines in between, nothing known beyond
  double sigma_us = 0;        ///< standard deviation of its place in camera time, >= 0
};

/// The arm's speed through its clock; 0 where the arm rests, which is beyond `moves` and the ringing after each.
/// @param moves  of this arm, by time
SeenMotion seen_motion(const ArmMotion& arm, std::span<const CameraSpan> moves, const FittedClock& robot_clock);

/// Relates a film's clock to the camera's by what moves in both.
///
/// 1. The likeness of the film's energy and the speed it should have seen, at every offset: their correlation over the steps from
///    frame to frame, each step with the mean of the speed over its length. It is lower where much of either lies beyond the
///    other's end. First in steps of half a frame (longer films: of up to a 4096th of the film), then around the best of them to
///    a millisecond and by a parabola.
/// 2. Around each start and stop of the motion, a x speed + c is fitted to the energies, and moved in time until it leaves least.
///    A film that underestimates slow motion sees starts late and stops early by the same time, so that their mean is right.
///    Their difference shows how far the model can be trusted: half of it, and a 32nd of a frame with twice the weight, are taken
///    as the standard deviation of that mean. A start or stop alone has a 16th of a frame.
/// 3. `fit_clock` through the middles of the motions. Start and stop of one motion are too close for a drift: their offsets
///    differ by 1.5 ms by chance, which is 0.3 % of a lift.
///
/// Refused where the likeness is below 0.8 or less than 1.5 times that of another offset; and, as a contradiction, where start
/// and stop of a motion place the film more than 60 ms apart.
/// @param energy  of the run's film
/// @param seen    of the same run; other motion in the film does not matter if it is weaker or lasts for another time
VideoClockFit fit_video_clock(const MotionEnergy& energy, const SeenMotion& seen);

}  // namespace tactile::alignment
