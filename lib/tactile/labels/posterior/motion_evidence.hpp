#pragma once

#include <span>
#include <vector>

#include "tactile/labels/posterior/place_counts.hpp"
#include "tactile/labels/posterior/run_states.hpp"

namespace tactile::labels {

/// Of each place: its events per bin while nothing moves, > 0, and its share of the events of motions. Shares sum to 1.
struct PlaceRates {
  std::vector<double> quiet, share;
  std::vector<double> gain = {};     ///< of the noise, in each bin: it drifts by some percent
  std::size_t bins_of_own_gain = 1;  ///< in which the own gains stay the same
  std::vector<float> own_gain = {};  ///< of each place, [stretch of bins, place]; empty: 1

  double gain_at(std::size_t bin, std::size_t place) const {
    return own_gain.empty() ? gain[bin] : gain[bin] * own_gain[bin / bins_of_own_gain * PlaceCounts::places + place];
  }
};

/// From the calmest third of the recording, and own gains as in `rates_given`, corrected for this choice: the mean of the lowest
/// third of Poisson counts with mean m is m - 1.09 sqrt(m). All places have the same share.
PlaceRates first_rates(const PlaceCounts& counts);

/// From where the skin is known to be quiet, and to move. In a recording of several runs, hot pixels come and go: each place has
/// its own gain, the median over 10 s of its rates over 500 ms, so that a motion of up to 5 s does not count; drawn to 1 as for a
/// drift of 30 % (standard deviation), in steps of 4 %. Else all have one gain. It is that of the half of the places whose events
/// grow least by motions: the median over 1.25 s of the rates over 250 ms, drawn to 1 as for a drift of 10 % (standard
/// deviation), from 0.8 to 1.25 in steps of 2 %.
/// @param quiet, moves  probabilities, of each bin
PlaceRates rates_given(const PlaceCounts& counts, std::span<const double> quiet, std::span<const double> moves);

/// ln p(all counts | level 0) but for what does not depend on the rates, divided by the noise's dispersion.
double log_likelihood_of_quiet(const PlaceCounts& counts, const PlaceRates& rates);

/// The variance over the mean of the noise of all places together, in bins of 8 ms: 1 for Poisson's, more where pixels flicker
/// together. From the median of squared differences of neighbours, so that motions and drift count for little. At least 1.
double dispersion_of_noise(const PlaceCounts& counts);

/// ln p(counts of bin | level) - ln p(counts of bin | level 0), [bin, level]; 0 in gaps of the recording. With n events of a
/// place of quiet rate q and share w, at a level of s events in a bin:
///
///   n ~ Poisson(q + m),  m ~ Gamma with mean s w and shape 1/2, approximated by the negative binomial of the same mean and
///   variance: r = mean^2 / (variance - mean),  ln p = lgamma(n + r) - lgamma(r) - lgamma(n + 1) + r ln(r / (r + mean)) + n
///   ln(mean / (r + mean))
///
/// q includes the gain. The shape says that a motion moves few of the places at once. At least -200. All is divided by the
/// noise's dispersion (quasi-likelihood: McCullagh and Nelder, Generalized Linear Models, 1989, chapter 9).
std::vector<double> motion_evidence(const PlaceCounts& counts, const PlaceRates& rates);

}  // namespace tactile::labels
