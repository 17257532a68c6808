#pragma once

#include <vector>

#include "tactile/labels/labels.hpp"

namespace tactile::labels {

/// The shortest press: a stage of 20 mm/s pushes the skin in by 0.4 mm, the least that the simulation's objects have.
inline constexpr microseconds shortest_press{20'000};

/// Presses that may be another motion, as flags of their intervals:
///
/// - one that is shorter than `shortest_press`, as a part of the skin that springs back;
/// - one that follows another press although no release was found between them: an object that turns, or slips in part, while it
///   is held moves the skin as much as a press.
///
/// @param labels  intervals and releases, by start
std::vector<LabelFlag> unlikely_presses(const Labels& labels);

}  // namespace tactile::labels
