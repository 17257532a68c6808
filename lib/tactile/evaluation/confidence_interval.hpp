#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "tactile/results/figure.hpp"

namespace tactile::evaluation {

/// Runs by their index, one list for each object. A drawn object or run may stand in it several times.
using RunsByObject = std::vector<std::vector<std::size_t>>;

/// A figure of the given runs; nothing where there is nothing to measure, such as a delay of runs without a detection.
using Statistic = std::function<std::optional<double>(const RunsByObject&)>;

/// The figure of one object: its runs are drawn with replacement, and the interval holds the middle 95 % of what the draws give.
///
/// Every figure with the same number of runs is made from the same draws, so figures of the same runs are paired; a difference is
/// a `statistic` that subtracts. Draws that give nothing are left out; fewer than half left, and there is no interval.
results::Figure figure_of_object(std::span<const std::size_t> runs, const Statistic& statistic,
                                 const results::BootstrapOptions& options = {});

/// The figure over objects: objects are drawn with replacement first, then as many runs within each as it has.
results::Figure figure_over_objects(const RunsByObject& runs, const Statistic& statistic,
                                    const results::BootstrapOptions& options = {});

/// A statistic that averages over objects what `of_object` gives of each one's runs; objects that give nothing are left out.
Statistic mean_over_objects(std::function<std::optional<double>(std::span<const std::size_t>)> of_object);

/// An upper bound on the expected number of rare events, where `count` occurred: the mean m of a Poisson distribution with
/// P(X <= count | m) = (1 - confidence) / 2, the upper end of the exact two-sided interval; 3.69 for a count of 0, at 95 %.
/// Source: F. Garwood, Fiducial limits for the Poisson distribution, Biometrika 28 (1936).
double poisson_upper_bound(std::uint64_t count, double confidence = 0.95);

}  // namespace tactile::evaluation
