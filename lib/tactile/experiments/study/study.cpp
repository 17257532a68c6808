#include "tactile/experiments/study/study.hpp"

#include <utility>

#include "tactile/core/command_lock.hpp"
#include "tactile/experiments/study/judge_models.hpp"
#include "tactile/experiments/study/study_results.hpp"

namespace tactile::study {

StudySummary run_study(const StudyOptions& requested, const experiments::NewProgress& new_progress,
                       const experiments::StepCallback& on_step, const WarningCallback& warn) {
  const unsigned threads = completed(requested, false).threads;  // refuses wrong options before anything is made
  const CommandLock lock(requested.out, "tactile reproduce");
  experiments::StepRunner runner({.folder = requested.out,
                                  .program = requested.program,
                                  .threads = threads,
                                  .new_progress = new_progress,
                                  .on_step = on_step,
                                  .slurm = requested.slurm});
  const StudyOptions options = completed(requested, has_own_runs(requested, runner));
  std::vector<PreparedWorld> worlds;
  StudySummary summary;
  for (const World& world : worlds_of(options)) {
    worlds.push_back(prepare_world(options, world, runner, warn));
    summary.errors.insert(summary.errors.end(), worlds.back().errors.begin(), worlds.back().errors.end());
  }
  const StudyPlan plan = plan_study(options, std::move(worlds), warn);
  train_and_judge(plan, runner);
  std::vector<results::ReportedRun> runs = predict_runs(plan, runner);
  const std::vector<results::Cell> cells = cells_of(plan);
  summary.study = results_of(plan, cells, std::move(runs), runner.records());
  write_results(summary.study, cells, options.out);
  summary.file = options.out / "study.json";
  summary.done = runner.done_now();
  summary.kept = runner.kept();
  return summary;
}

}  // namespace tactile::study
