#pragma once

#include <span>
#include <vector>

#include "tactile/labels/posterior/place_counts.hpp"
#include "tactile/labels/posterior/run_states.hpp"

namespace tactile::labels {

/// The bins [begin, end) of what may be a press.
struct PressBins {
  std::size_t begin = 0, end = 0;
  double weight = 1;       ///< of its pattern in the mean
  double probability = 1;  ///< that it is a press; the greatest one weighs the evidence
};

/// ln p(pattern of the bin | happening) less that of any other motion, [bin, happening].
///
/// The pattern of a press is, for each cell, its brighter less its darker events. A release goes back: its pattern is the
/// opposite. Another press has the same, a slip neither. The cosine c of the patterns of a block of 50 ms, and of the presses
/// that it is in none of, is
///
///   press: c ~ N(1/2, 1/4),  release: c ~ N(-1/2, 1/4),  any other: c ~ N(0, 0.15)   (standard deviations)
///
/// widened by the noise of the counts. A block counts for 0.4 of itself, because blocks of one motion are alike. Blocks without a
/// clear pattern say nothing.
/// @param moves  probability of motion, of each bin
std::vector<double> pattern_evidence(const PlaceCounts& counts, std::span<const PressBins> presses,
                                     std::span<const double> moves);

}  // namespace tactile::labels
