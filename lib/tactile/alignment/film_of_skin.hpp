#pragma once

#include <span>

#include "tactile/alignment/video_clock.hpp"

namespace tactile::alignment {

/// A stretch in which the skin fires: a motion that touches or drags it.
struct SeenBurst {
  CameraTime start{}, end{};
};

/// Relates a film's clock to the camera's by the events alone, less accurately than by the arm. A motion in the film ends when a
/// burst does, and starts with it or before it (a stage moves before it touches); or it starts with the burst and ends later
/// (tips that leave the object early). The offset at which most do so, and best, is taken. It is refused where no motion starts
/// with its burst: two ends may lie as far apart as two others by chance. It is also refused where only one burst fits, unless it
/// clearly starts and ends with a motion. Slack, ringing and slow ends shift a burst against the film's motion: each has a
/// standard deviation of 15 ms besides the film's own, and all together one of 10 ms. Motions that change the film by less than
/// 0.5 % of the largest do not count.
VideoClockFit fit_video_clock(const MotionEnergy& energy, std::span<const SeenBurst> bursts,
                              const VideoClockOptions& options = {});

}  // namespace tactile::alignment
