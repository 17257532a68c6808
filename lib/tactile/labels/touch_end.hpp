#pragma once

#include <optional>

#include "tactile/labels/onset.hpp"

namespace tactile::labels {

struct EndOptions {
  double still_share = 0.01;             ///< of the peak speed: a slower touch is still
  microseconds press_still{20'000};      ///< a press ends at the first stillness of this length
  microseconds slip_still{150'000};      ///< a slip ends at the first stillness of this length: stick phases belong to it
  microseconds rung_out{50'000};         ///< after the arm's stop the tips of a slip stand still
  microseconds longest_unseen{200'000};  ///< a slip that is not seen for longer before the arm's stop ends where it was last seen
  microseconds stick_phase{10'000};      ///< so much of the last stick phase may lie before the arm's stop
  microseconds least_error{3'000};       ///< added to either side: creep and hysteresis shift an end by some milliseconds
  double too_wide_ms = 200.0;  ///< doubtful if wider: the error may exceed the guard between a touch and samples of none
};

/// When the press's speed fell below 1 % of its peak. A marker's events show its speed until they fade into the noise; the rest
/// is extrapolated. With T the time at which the stage stands still, by maximum likelihood of the last half of the decline:
///
///   rate(t) = z + g (T - t)^p for t < T;   z after it        end = T - (T - onset) 0.01^(1/p)
///
/// The 95 % interval holds every end whose T and p are within 1.92 of the best log-likelihood, divided by the residuals'
/// dispersion. Doubtful where z, the tips' creeping, is itself near 1 % of the peak.
FoundTime press_end(const LitRate& lit, const alignment::UncertainTime& onset, const EndOptions& options = {});

/// When object and tips stood still against each other: below 1 % of the slip's peak speed for 150 ms. The camera sees the tips
/// only, and their last ringing only where it moves an edge by about a tenth of a pixel. The ringing decays exponentially: with t
/// the last time at which the rate has 1 % of its peak, and tau the time in which it fell by a factor of e until then,
///
///   end = t + 4 tau,   from t - 9 ms (an arm that stops within a stick phase) to t + 6 tau + 20 ms (a surface that runs past
///   unseen)
///
/// If the arm's stop is known, the object may slide until then: no end is earlier, and the interval reaches at least as far.
/// Where nothing is seen for more than 200 ms before that, the object may also have left: the end is where it was last seen. Tips
/// that are no longer dragged stop ringing within 50 ms; longer motion is the arm's own ringing, which is no slip. The end is
/// there at the latest, and the interval reaches back to the stop.
///
/// A tail of more than 60 ms below a tenth of the peak may be the arm's ringing where it stops, or tips without an object: the
/// interval then reaches back to 50 ms before it begins. The interval is wide because the camera shows no more.
/// @param arm_stop  if it is known, in camera time
FoundTime slip_end(const LitRate& lit, const alignment::UncertainTime& onset, const EndOptions& options = {},
                   const std::optional<alignment::UncertainTime>& arm_stop = std::nullopt);

}  // namespace tactile::labels
