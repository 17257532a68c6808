#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/labels/activity.hpp"
#include "tactile/labels/brightness_change.hpp"

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
  microseconds brief{40'000};       ///< a burst that is shorter than this
  double brief_share = 0.1;         ///< and has less than this share of the largest burst's events is none of a touch
  double release_likeness = -0.25;  ///< a burst whose `likeness` to the press before it is below this takes it back; -1 to 0
};

/// Tells bursts apart, in order of time:
///
/// - Of each lift the burst that has the most events in it is the slip. Where nobody knows of a lift the last burst is, unless
/// the
///   arm is known not to have risen.
/// - What lies in a tap of the arm is the tap.
/// - What is short and small is brief; what follows the last slip is `after`.
/// - Any other burst is a press, unless it takes back the press before it: a marker that goes back leaves dark where it had left
///   bright.
///
/// @param lifts    nothing: nobody knows whether the arm rose
/// @param changes  of each burst
std::vector<BurstKind> kinds_of(const EventRate& rate, std::span<const Burst> bursts,
                                const std::optional<std::vector<ArmMove>>& lifts, std::span<const ArmMove> taps,
                                std::span<const BrightnessChange> changes, const TouchesOptions& options = {});

}  // namespace tactile
