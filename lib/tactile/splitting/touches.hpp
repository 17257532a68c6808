#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/alignment/activity.hpp"

namespace tactile::splitting {

/// A motion of the arm, in camera time.
struct ArmMove {
  CameraTime start{}, end{};
  microseconds uncertainty{0};  ///< 95 %: how far the clock may be off, either way
};

/// The move that a burst lies in; null if there is none.
const ArmMove* move_around(const std::vector<ArmMove>& moves, const alignment::EventRate& rate, const alignment::Burst& burst);

/// What a burst of events comes from.
enum class BurstKind : std::uint8_t {
  press,
  slip,
  release,  ///< the end of a press
  tap,      ///< the arm sets the sensor against something for an instant
  brief,    ///< too short and too small for a touch: a micro-slip
  after     ///< after the slip: creep, ringing, another contact
};

struct TouchesOptions {
  microseconds shortest_press{100'000};       ///< of a second press on top of the first
  microseconds shortest_slow_press{150'000};  ///< of one that only a few places show
  double deepens = 0.4;                       ///< a burst whose `undoes` is less than the negative of this presses deeper, 0 to 1
  double like_a_press = 0.1;                  ///< of the standing press's events: the least of its release, or of a deeper press
  double releases = 0.5;                      ///< a burst whose `undoes` is greater is a release, 0 to 1
};

/// Classifies bursts, in order of time:
///
/// - Of each lift, the burst with the most events in it is the slip; a slow one only if there is no other and a press stands.
///   If it is not known whether the arm rose, the last burst that reverses nothing is the slip.
/// - A burst during a tap of the arm is the tap.
/// - A burst after the last slip that reverses what came before is a release, any other is `after`. One for which
///   `is_after_effect` holds is brief. While a press stands, a burst is also brief if it is smaller than that press, and shorter
///   than a stage takes or slow: tips that spring back or creep. It is not brief if it lasts more than half as long as that press
///   and reverses its effect on the picture (a fast stage opens), or more than a third as long and repeats it (a fast stage
///   presses deeper). A slow one that is short is brief too, unless it is a release.
/// - Any other burst is a press, unless a press stands and the burst reverses it: a marker that moves back leaves dark where
///   it had left bright.
///
/// @param lifts   nothing: it is not known whether the arm rose
/// @param undoes  of each burst, how far it reverses all bursts before it, -1 to 1: minus the correlation of `Brightening`
std::vector<BurstKind> kinds_of(const alignment::EventRate& rate, std::span<const alignment::Burst> bursts,
                                const std::optional<std::vector<ArmMove>>& lifts, std::span<const ArmMove> taps,
                                std::span<const double> undoes, const TouchesOptions& options = {});

}  // namespace tactile::splitting
