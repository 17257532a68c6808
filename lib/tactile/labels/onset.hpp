#pragma once

#include <optional>
#include <string>

#include "tactile/labels/labels.hpp"
#include "tactile/labels/lit_rate.hpp"

namespace tactile {

/// An onset or an end with its 95 % interval. Where the events do not decide, the interval is wide and `doubt` says why; else it
/// is empty.
struct FoundTime {
  UncertainTime time;
  std::string doubt;
};

struct OnsetOptions {
  microseconds before{60'000};          ///< a slip is searched for so far ahead of where its burst begins
  microseconds first_contact{300'000};  ///< and a first, weak contact so far ahead of a press's
  microseconds rise{150'000};           ///< how fast a slip's tips get is seen within so much time
  microseconds first_drag{25'000};      ///< and how fast the first drag is within so much time
  microseconds latency{400};            ///< a marker may have moved so long before its first event, at least
  microseconds longest_blind{15'000};   ///< and at most
  microseconds blind_anew{40'000};      ///< or, where noise has set all pixels anew
  double too_wide_ms = 20.0;            ///< doubtful if the interval is wider than this
};

/// When contact first moved a marker, by maximum likelihood on the rate of what the press lights. With tau the onset, q the
/// quiet rate, u = t - tau:
///
///   rate(t) = q for u < 0;   q + a u^p for u >= 0,   p = 0 (a blow: the object arrives at speed) or 1 (a start from rest)
///
/// for as long as the events stand out beyond doubt. A marker that is touched a little, or moves little in the image, may have
/// come first: the same question is then asked of the time ahead of what was found, of all that is lit and of each lit place by
/// itself, whose own noise is a tenth of all's, until no step there is likelier than none. Markers that are touched one after
/// the other make a rise of any shape; at each of them the rate jumps.
///
/// The 95 % interval is where the log-likelihood, divided by the noise's dispersion, is within 1.92 of its maximum, stretched to
/// what a first contact that is likely but not beyond doubt would have, and by the time for which the pixels of the place that
/// it begins at were blind.
FoundTime press_onset(const LitRate& lit, const OnsetOptions& options = {});

/// When the lift first moved a tip. As it starts, the arm rings, and so do the tips; the object drags them along only once the
/// slack is used up, and then at the speed that the arm has by then. So three stretches, with rho <= tau:
///
///   rate(t) = q for t < rho;   q + s (t - rho) for rho <= t < tau;   q + s (tau - rho) + b + c (t - tau) for t >= tau
///
/// with s, b, c >= 0, against the same without the ringing (s = 0), which is preferred unless the other is likelier by 4.
/// Ringing is what has at most half of the rate that the drag reaches. The interval holds both models' tau.
///
/// @param lift_start  where it is known, in camera time; no slip begins ahead of its interval
FoundTime slip_onset(const LitRate& lit, const OnsetOptions& options = {},
                     const std::optional<UncertainTime>& lift_start = std::nullopt);

}  // namespace tactile
