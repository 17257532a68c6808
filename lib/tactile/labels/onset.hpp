#pragma once

#include <optional>
#include <string>

#include "tactile/core/doubt.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/lit_rate.hpp"

namespace tactile::labels {

constexpr double half_chi2 = 1.92;  ///< half of the 95 % point of chi^2 with one degree of freedom

/// An onset or an end with its 95 % interval. Where the events do not decide, the interval is wide and `doubt` gives the reason;
/// else `doubt` is empty.
struct FoundTime {
  alignment::UncertainTime time;
  Doubt doubt;
};

struct OnsetOptions {
  microseconds before{60'000};          ///< a slip is searched from this long before its burst's start
  microseconds first_contact{300'000};  ///< a first, weak contact is searched from this long before a press's burst
  microseconds rise{150'000};           ///< a slip's tips reach their speed within this time
  microseconds first_drag{25'000};      ///< the first drag reaches its speed within this time
  microseconds latency{400};            ///< the least time by which a marker may move before its first event
  microseconds noise_ahead{400};        ///< this long before an onset, noise may look like its first event
  microseconds longest_blind{15'000};   ///< the greatest such time
  microseconds blind_reset{40'000};     ///< the same where noise has reset all pixels
  double press_blind_share = 0.6;       ///< of that time: where a press begins, some of many pixels are near their threshold
  double too_wide_ms = 40.0;            ///< doubtful if the interval is wider than this
};

/// When contact first moved a marker, by maximum likelihood on the rate of what the press lights. With tau the onset, q the
/// quiet rate, u = t - tau:
///
///   rate(t) = q for u < 0;   q + a u^p for u >= 0,   p = 0 (a blow: the object arrives at speed) or 1 (a start from rest)
///
/// up to where the events stand out clearly. A marker that is touched lightly, or moves little in the image, may be touched
/// first. So the time before the found onset is searched again for a step, in all lit places together and in each by itself,
/// which has a tenth of the noise, until no step is likelier than none. Markers that are touched one after the other make a rise
/// of any shape; at each of them the rate jumps.
///
/// The 95 % interval is where the log-likelihood, divided by the noise's dispersion, is within 1.92 of its maximum. It is
/// extended to that of a first contact that is likely but not sure, and by the time for which the pixels of the first place were
/// blind.
///
/// @param earliest  the end of the burst before, whose decline is no contact; nothing if there is none
FoundTime press_onset(const LitRate& lit, const OnsetOptions& options = {}, std::optional<CameraTime> earliest = std::nullopt);

/// When the lift first moved a tip. At its start the arm rings, and the tips with it. The object drags them only once the slack
/// is used up, at the speed that the arm has by then. So there are three stretches, with rho <= tau:
///
///   rate(t) = q for t < rho;   q + s (t - rho) for rho <= t < tau;   q + s (tau - rho) + b + c (t - tau) for t >= tau
///
/// with s, b, c >= 0. The same model without ringing (s = 0) is preferred unless the other is likelier by 4. Ringing has at most
/// half of the rate that the drag reaches. The interval holds the tau of both models.
///
/// A gradual rise that a sharper one follows soon is a partial slip: first some tips slip, then all. The interval reaches to the
/// sharper rise. If the arm rings, the gradual rise may be its ringing, and the onset is in doubt.
///
/// @param lift_start  if it is known, in camera time; no slip begins before its interval
/// @param arm_rings   whether the robot log shows that the arm rings when it lifts; nothing without such a log. The model without
///                    ringing is used alone where it does not ring
FoundTime slip_onset(const LitRate& lit, const OnsetOptions& options = {},
                     const std::optional<alignment::UncertainTime>& lift_start = std::nullopt,
                     std::optional<bool> arm_rings = std::nullopt);

}  // namespace tactile::labels
