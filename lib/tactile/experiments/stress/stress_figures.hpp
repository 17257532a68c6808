#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/experiments/stress/judge_runs.hpp"
#include "tactile/results/stress.hpp"

namespace tactile::stress {

/// All runs at one severity; `severity` and the change to the harmless one are not set. Figures are those of `tactile eval`.
results::StressPoint point_of(std::span<const results::Cell> outcomes, const results::BootstrapOptions& options = {});

/// The first severity at which the accuracy is `most_lost` below that at the first severity, linear between severities; nothing
/// if it never falls so far. A loss of exactly `most_lost` still holds.
///
///   severity_where_lost({0, 10, 20}, {0.9, 0.9, 0.8}, 0.05) = 15
///
/// @param severities  ascending   @param accuracies  one for each
std::optional<double> severity_where_lost(std::span<const double> severities, std::span<const double> accuracies,
                                          double most_lost);

/// The severity up to which the mean accuracy over objects holds. The interval draws trainings, objects and runs; a draw that
/// never falls so far counts with the last severity. The interval lies within the severities.
/// @param outcomes  at each severity, the harmless one first, of the same trainings and runs in the same order
/// @return  nothing where there are no samples
/// @throws Error  if they are not of the same runs
std::optional<results::HoldsUpTo> holds_up_to(std::span<const double> severities,
                                              std::span<const std::vector<results::Cell>> outcomes, double most_lost,
                                              const results::BootstrapOptions& options = {});

/// The points of a curve: figures at each severity, and the changes of accuracy.
/// @param outcomes  as of `holds_up_to`
/// @param threads   > 0; the result does not depend on it
std::vector<results::StressPoint> points_of(std::span<const double> severities,
                                            std::span<const std::vector<results::Cell>> outcomes, unsigned threads,
                                            const results::BootstrapOptions& options = {});

}  // namespace tactile::stress
