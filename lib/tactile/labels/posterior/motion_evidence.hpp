#pragma once

#include <span>
#include <vector>

#include "tactile/labels/posterior/place_counts.hpp"
#include "tactile/labels/posterior/run_states.hpp"

namespace tactile::labels {

/// Of each place: its events per bin while nothing moves, > 0, and its share of the events of motions. Shares sum to 1.
struct PlaceRates {
  std::vector<double> quiet, share;
};

/// From the calmest third of the recording, corrected for this choice: the mean of the lowest third of Poisson counts with mean m
/// is m - 1.09 sqrt(m). All places have the same share.
PlaceRates first_rates(const PlaceCounts& counts);

/// From where the skin is known to be quiet, and to move. @param quiet, moves  probabilities, of each bin
PlaceRates rates_given(const PlaceCounts& counts, std::span<const double> quiet, std::span<const double> moves);

/// ln p(counts of bin | level) - ln p(counts of bin | level 0), [bin, level]. With n events of a place of quiet rate q and share
/// w, at a level of s events in a bin:
///
///   n ~ Poisson(q + m),  m ~ Gamma with mean s w and shape 1/2, approximated by the negative binomial of the same mean and
///   variance: r = mean^2 / (variance - mean),  ln p = lgamma(n + r) - lgamma(r) - lgamma(n + 1) + r ln(r / (r + mean)) + n
///   ln(mean / (r + mean))
///
/// The shape says that a motion moves few of the places at once. At least -200.
std::vector<double> motion_evidence(const PlaceCounts& counts, const PlaceRates& rates);

}  // namespace tactile::labels
