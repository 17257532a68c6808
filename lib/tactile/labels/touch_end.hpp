#pragma once

#include <optional>

#include "tactile/labels/onset.hpp"

namespace tactile {

struct EndOptions {
  double still_share = 0.01;         ///< of the peak speed: slower is still
  microseconds press_still{20'000};  ///< a press ends at the first so long stillness
  microseconds slip_still{150'000};  ///< a slip likewise: stick phases belong to it
  microseconds rung_out{50'000};     ///< behind the arm's stop the tips of a slip stand still
  microseconds stick_phase{10'000};  ///< of the last stick phase, so much may lie ahead of the arm's stop
  microseconds least_error{1'000};   ///< no interval reaches less far to either side
  double too_wide_ms = 200.0;  ///< doubtful if wider: it may be off by more than the guard between a touch and samples of none
};

/// When the press's speed fell below 1 % of its peak. A marker's speed shows in its events up to where they fade into the noise;
/// the rest is extrapolated. With T when the stage stands still, fitted by maximum likelihood to the last half of the decline:
///
///   rate(t) = z + g (T - t)^p for t < T;   z after it        end = T - (T - onset) 0.01^(1/p)
///
/// The 95 % interval holds every end whose T and p are within 1.92 of the best log-likelihood, divided by the residuals'
/// dispersion. Doubtful where z, the tips' creeping, is itself near 1 % of the peak.
FoundTime press_end(const LitRate& lit, const UncertainTime& onset, const EndOptions& options = {});

/// When object and tips stood still against each other: below 1 % of the slip's peak speed for 150 ms. The camera sees the tips
/// alone, and of their last ringing only what moves an edge by a tenth of a pixel or so. It dies away exponentially: with t the
/// last time that the rate has 1 % of its peak, and tau the time in which it fell by a factor of e until then,
///
///   end = t + 4 tau,   from t - 9 ms (an arm that stops within a stick phase) to t + 6 tau + 20 ms (a surface that runs past
///   unseen)
///
/// Where the arm's stop is known the object slides on until then, for all that is seen: no end is put ahead of it, and the
/// interval reaches at least as far. Tips that nobody drags have rung out 50 ms later; what goes on for longer is the arm's own
/// ringing, which is nobody's: the end is put there at the latest, and the interval reaches back to the stop.
///
/// A tail of more than 60 ms below a tenth of the peak may be the arm's ringing where it stops: the interval then reaches back to
/// its begin. The interval is wide since nothing that the camera sees tells more.
/// @param arm_stop  where it is known, in camera time
FoundTime slip_end(const LitRate& lit, const UncertainTime& onset, const EndOptions& options = {},
                   const std::optional<UncertainTime>& arm_stop = std::nullopt);

}  // namespace tactile
