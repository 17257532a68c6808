#pragma once

#include <span>
#include <vector>

#include "tactile/results/cell.hpp"
#include "tactile/results/whole_runs.hpp"

namespace tactile::evaluation {

/// The false alarms a minute that `WholeRuns::calm` is asked for.
inline constexpr double calm_rates[] = {20, 6, 2, 0.6};

/// What cells of one setting and threshold have together. Intervals are those of `RunFigures`. That of a rate of alarms ends no
/// lower than the exact one of their count. A quantile among touches that are not detected has none.
/// @param cells  at least one
results::OperatingPoint operating_point(std::span<const results::Cell> cells, const results::BootstrapOptions& options = {});

/// The same without intervals.
results::OperatingPoint operating_values(std::span<const results::Cell> cells);

/// All figures of whole runs.
/// @param cells    of one setting: those of the verdicts as they were decided, and of each threshold
/// @param threads  > 0; no figure depends on it
/// @return         without `left_out`
results::WholeRuns whole_runs(std::span<const results::Cell> cells, unsigned threads,
                              const results::BootstrapOptions& options = {});

/// Those of a published detector. @param cells  as those of `whole_runs`, at least one
results::Baseline baseline_of(std::span<const results::Cell> cells, unsigned threads,
                              const results::BootstrapOptions& options = {});

}  // namespace tactile::evaluation
