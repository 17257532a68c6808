#include "tactile/alignment/video_clock.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace tactile::alignment {

std::string set_ambiguity(VideoClockFit& fit, double best, double second, const VideoClockOptions& options) {
  constexpr double no_other = 99;
  fit.ambiguity = second > 0 ? std::min(best / second, no_other) : no_other;
  if (fit.ambiguity >= options.least_ambiguity) return {};
  return fmt::format("the film matches at two offsets: the better is only {:.2f} times as good; expected {:.2f}", fit.ambiguity,
                     options.least_ambiguity);
}

VideoClockFit with_clock(VideoClockFit fit, const MotionEnergy& energy) {
  const VideoTime middle = energy.begin() + (energy.end() - energy.begin()) / 2;
  ClockFit line = fit_clock(fit.anchors, us_of(energy.begin()), {.middle_us = us_of(middle)});
  fit.clock = std::move(line.clock);
  fit.refused = std::move(line.refused);
  return fit;
}

}  // namespace tactile::alignment
