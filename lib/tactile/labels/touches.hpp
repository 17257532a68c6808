#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/labels/activity.hpp"

namespace tactile {

/// A motion of the arm, in camera time.
struct ArmMove {
  CameraTime start{}, end{};
  microseconds uncertainty{0};  ///< 95 %: how far the clock may be off, either way
};

/// What a burst of events comes from.
enum class BurstKind : std::uint8_t {
  press,
  slip,
  release,  ///< a press is taken back
  tap,      ///< the arm sets the sensor against something for an instant
  brief,    ///< too short and too small to be a touch: a micro-slip
  after     ///< the slip is over: creep, ringing, another contact
};

struct TouchesOptions {
  microseconds shortest_press{100'000};  ///< of a second press on top of the first
  double releases = 0.5;                 ///< a burst that undoes what was done before it by more than this is a release, 0 to 1
};

/// Tells bursts apart, in order of time:
///
/// - Of each lift the burst that has the most events in it is the slip. Where nobody knows of a lift the last burst is, unless
/// the
///   arm is known not to have risen.
/// - What lies in a tap of the arm is the tap.
/// - What follows the last slip is `after`; what `is_after_effect` brief. So is, while a press stands, what is shorter than a
/// stage
///   takes and smaller than that press: tips that spring back.
/// - Any other burst is a press, unless a press stands and it takes that back: a marker that goes back leaves dark where it had
///   left bright.
///
/// @param lifts   nothing: nobody knows whether the arm rose
/// @param undoes  of each burst, as `LitRate` has it
std::vector<BurstKind> kinds_of(const EventRate& rate, std::span<const Burst> bursts,
                                const std::optional<std::vector<ArmMove>>& lifts, std::span<const ArmMove> taps,
                                std::span<const double> undoes, const TouchesOptions& options = {});

}  // namespace tactile
