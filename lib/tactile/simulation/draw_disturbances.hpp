#pragma once

#include "tactile/core/random.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile::simulation {

/// Adds what disturbs a run at any time: micro-slips, partial slips, turns of the object, hysteresis of the tips and drift of the
/// light. It draws last, so a run without these is the same whether they could have been drawn or not.
void draw_disturbances(RunPlan& plan, const ObjectModel& object, const RunPlanOptions& options, Random& random);

/// The markers that a press touches. @return  bit i: marker i
unsigned touched_markers(const PressPlan& press);

}  // namespace tactile::simulation
