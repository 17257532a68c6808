#pragma once

#include "tactile/experiments/estimate.hpp"
#include "tactile/experiments/stress/plan_stress.hpp"

namespace tactile::stress {

/// What `run_stress` would do with these options. Measures this machine's speed in training, for a second; writes nothing.
/// The times are estimates, as those of `study::estimate_study`.
/// @throws Error  as `plan_stress`, or if a recording cannot be read
experiments::Estimate estimate_stress(const StressOptions& options);

}  // namespace tactile::stress
