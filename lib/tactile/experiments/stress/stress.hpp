#pragma once

#include <cstddef>
#include <filesystem>

#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/stress/plan_stress.hpp"
#include "tactile/results/stress.hpp"

namespace tactile::stress {

/// The outcome of `run_stress`.
struct StressSummary {
  results::Stress stress;  ///< the contents of stress.json
  std::filesystem::path file;
  std::size_t done = 0, kept = 0;  ///< number of steps done now, and found done
};

/// Worsens runs by each series at each severity, and judges the models on them. Events are changed while they are read: no
/// changed recording is stored. Runs of simulated worlds are kept in `out/worlds`. Keeps all that is done and unchanged; an
/// interrupted call resumes. On a cluster each judgement is a task. Writes `out/stress.json` and `out/stress.csv`.
/// @throws Error  as `plan_stress`, or if another process works in the same folder, or a step fails
StressSummary run_stress(const StressOptions& options, const experiments::NewProgress& new_progress = {},
                         const experiments::StepCallback& on_step = {});

}  // namespace tactile::stress
