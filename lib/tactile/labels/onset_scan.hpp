#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/labels/onset.hpp"

// What the onsets of press and slip have in common: the likelihood of a rise of the rate at each bin.
namespace tactile::labels {

using Counts = std::span<const std::uint32_t>;

/// Sums of counts between bins in constant time.
class Sums {
 public:
  explicit Sums(Counts counts) : until_(counts.size() + 1) {
    for (std::size_t i = 0; i < counts.size(); ++i) until_[i + 1] = until_[i] + counts[i];
  }
  double of(std::size_t begin, std::size_t end) const { return until_[end] - until_[begin]; }

 private:
  std::vector<double> until_;
};

/// sum of n ln(rate) - rate, without the terms of the counts alone.
inline double log_likelihood_of(double events, double bins, double rate) { return events * std::log(rate) - rate * bins; }

/// A bin that holds events. Of the others only the number matters.
struct Filled {
  double at = 0, count = 0;
};

std::vector<Filled> filled_bins(Counts counts);
/// Those from bin `from` on.
std::span<const Filled> filled_from(const std::vector<Filled>& filled, std::size_t from);

/// The log-likelihood of the best rise of a rate, base + b + c x with b, c >= 0 and x in bins from the stretch's start.
/// @param filled  of the bins [from, to)
double best_rise(std::span<const Filled> filled, std::size_t from, std::size_t to, double base);

/// The likelihood that the rate begins to rise at each bin.
std::vector<double> rise_likelihoods(Counts counts, double quiet);

/// The best bin of a scan and its 95 % interval, each as the first bin after the change.
struct Scan {
  std::size_t best = 0, low = 0, high = 0;
};

Scan scan_of(const std::vector<double>& likelihood, double dispersion);

/// The events of a bin were caused since the read-out before it.
/// @param counts, repeats  of the place where it begins
/// @param blind_share      of the time for which its pixels were blind: the motion may begin this long before its first event
FoundTime found_at(const LitRate& lit, const Scan& scan, Counts counts, Counts repeats, double blind_share,
                   const OnsetOptions& options);

inline double half_event_per(std::size_t bins) { return 0.5 / static_cast<double>(std::max<std::size_t>(bins, 1)); }

}  // namespace tactile::labels
