#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tactile/labels/labels.hpp"

namespace tactile::labels {

inline constexpr std::size_t no_interval = static_cast<std::size_t>(-1);

/// The labels with a person's list of intervals. An interval that is gone is `rejected`; so is the place of one that has another
/// class now, or that was moved off the place where it was found, which would otherwise be found again. Rejected ones that
/// overlap a present interval of their class are dropped. Flags move along; those on confirmed intervals are confirmed.
/// @param intervals  by start; those without an id are named
/// @param new_index  of each interval of `labels`: its index in `intervals`, or `no_interval`
Labels with_intervals(Labels labels, std::vector<LabelledInterval> intervals, std::span<const std::size_t> new_index);

}  // namespace tactile::labels
