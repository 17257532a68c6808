#pragma once

#include <cstdint>
#include <string>

#include "tactile/core/random.hpp"
#include "tactile/simulation/physics.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile::simulation {

/// Nothing disturbs a run between press and lift but what the options say otherwise.
inline void leave_undisturbed(RunPlanOptions& options) {
  options.after.free_micro_slips_per_s = options.after.partial_slips_per_s = options.after.turn_chance = 0;
  options.after.hysteresis_share = {0, 0};
  options.variation.light_drift = {0, 0};
}

/// Short runs, all plain, and each new in everything.
inline RunPlanOptions short_runs() {
  RunPlanOptions options;
  leave_undisturbed(options);
  options.variation.new_share = 1;
  options.timings = {.quiet_s = {0.6, 0.75},
                     .travel_s = {0.15, 0.35},
                     .hold_s = {0.3, 0.42},
                     .lift_s = {0.35, 0.55},
                     .rest_s = {0.6, 0.8},
                     .between_s = {0.3, 0.4}};
  return options;
}

/// Runs that are all of one special kind, such as `only(&SpecialRuns::two_presses)`.
inline RunPlanOptions only(double SpecialRuns::*kind) {
  RunPlanOptions options = short_runs();
  options.special.two_presses = options.special.without_slip = options.special.without_press = options.special.firm_lifts =
      options.special.taps = 0;
  options.special.*kind = 1;
  options.run_number = options.special.from_run;
  options.may_be_special = true;
  return options;
}

inline RunPlan drawn_plan(const ObjectModel& object, const RunPlanOptions& options, std::uint64_t seed) {
  Random random(seed);
  return draw_run_plan(object, options, random);
}

}  // namespace tactile::simulation
