#pragma once

#include <span>
#include <vector>

#include "tactile/labels/posterior/place_counts.hpp"
#include "tactile/labels/posterior/run_states.hpp"

namespace tactile::labels {

/// ln p(pattern of the bin | happening) less that of any other motion, [bin, happening].
///
/// The pattern of a press is, for each cell, its brighter less its darker events. A release goes back: its pattern is the
/// opposite. Another press has the same, a slip neither. The cosine c of the patterns of a press and of a block of 50 ms is
///
///   press: c ~ N(1/2, 1/4),  release: c ~ N(-1/2, 1/4),  any other: c ~ N(0, 0.15)   (standard deviations)
///
/// widened by the noise of the counts. A block counts for 0.4 of itself, because blocks of one motion are alike. Blocks of the
/// press itself and blocks without a clear pattern say nothing.
/// @param press  its bins, [begin, end)  @param moves  probability of motion, of each bin
std::vector<double> pattern_evidence(const PlaceCounts& counts, std::size_t press_begin, std::size_t press_end,
                                     std::span<const double> moves);

}  // namespace tactile::labels
