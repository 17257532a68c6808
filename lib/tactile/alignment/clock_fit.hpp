#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/alignment/fitted_clock.hpp"

namespace tactile::alignment {

/// One moment on both clocks.
struct ClockAnchor {
  std::int64_t clock_us = 0;
  CameraTime camera{};
  double sigma_us = 0;  ///< standard deviation of their difference, of this anchor alone, > 0
  double bias_us = 0;   ///< standard deviation of the error that all anchors share: more of them do not reduce it
};

struct ClockFitOptions {
  std::optional<std::int64_t> middle_us;  ///< on the clock: where the 95 % interval holds; nothing: at the reference
  double most_drift_ppm = 200;            ///< crystals keep within 100; twice as much is no clock
  double usual_drift_ppm = 60;            ///< standard deviation of a drift that is not measured
  std::size_t drift_needs_anchors = 4;
  microseconds drift_needs_span{60'000'000};
  double reject_beyond = 3.0;  ///< robust standard deviations
};

/// A clock that was fitted, or why there is none.
struct ClockFit {
  std::optional<FittedClock> clock;
  std::string refused;     ///< a sentence, empty if there is a clock
  std::vector<bool> used;  ///< by anchor: not left out as too far off
};

/// Relates a clock to the camera's by a robust line through its anchors:
///
///   camera_us = clock_us + offset_us + drift_ppm * 1e-6 * (clock_us - reference_us)
///
/// Each anchor weighs 1 / (sigma^2 + bias^2). The line starts from Theil and Sen's gradient, then follows Huber's weights;
/// anchors beyond three robust standard deviations are left out. Where the anchors are too few or too close for a gradient,
/// the drift is 0, anchors far from the middle weigh less by what a usual drift would cause, and `method` says so. The interval
/// includes the anchors' own standard deviations (or their scatter, if larger), their common bias, and a drift that is not
/// measured.
///
/// Refused: no anchor, a drift beyond `most_drift_ppm`, clocks further apart than int64 holds, anchors of which two fifths
/// of the weight are left out, or that scatter by thirty times their own standard deviations.
ClockFit fit_clock(std::span<const ClockAnchor> anchors, std::int64_t reference_us, const ClockFitOptions& options = {});

}  // namespace tactile::alignment
