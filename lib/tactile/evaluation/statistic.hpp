#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace tactile::evaluation {

/// Results by their index, one list for each object. A drawn result may stand in it several times.
using RunsByObject = std::vector<std::vector<std::size_t>>;

/// A figure of the given results; nothing where there is nothing to measure, such as a delay of runs without a detection.
using Statistic = std::function<std::optional<double>(const RunsByObject&)>;

/// A statistic that averages over objects what `of_object` gives of each one's runs; objects that give nothing are left out.
Statistic mean_over_objects(std::function<std::optional<double>(std::span<const std::size_t>)> of_object);

/// An upper bound on the expected number of rare events, where `count` occurred: the mean m of a Poisson distribution with
/// P(X <= count | m) = (1 - confidence) / 2, the upper end of the exact two-sided interval; 3.69 for a count of 0, at 95 %.
/// Source: F. Garwood, Fiducial limits for the Poisson distribution, Biometrika 28 (1936).
double poisson_upper_bound(std::uint64_t count, double confidence = 0.95);

/// The exact two-sided interval of the probability of what occurred in `count` of `n` independent trials; [0.25, 44.5] % for 1 of
/// 10, at 95 %. Both may be any numbers: the bounds are quantiles of beta distributions. Source: C. J. Clopper and E. S. Pearson,
/// The use of confidence or fiducial limits, Biometrika 26 (1934).
/// @param count  in [0, n]
/// @param n      > 0
std::pair<double, double> binomial_bounds(double count, double n, double confidence = 0.95);

}  // namespace tactile::evaluation
