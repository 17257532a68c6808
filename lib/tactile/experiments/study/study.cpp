#include "tactile/experiments/study/study.hpp"

#include "tactile/core/command_lock.hpp"
#include "tactile/experiments/study/study_results.hpp"

namespace tactile::study {

StudySummary run_study(const StudyOptions& requested, const experiments::NewProgress& new_progress,
                       const experiments::StepCallback& on_step, const WarningCallback& warn) {
  const StudyOptions options = completed(requested);
  const CommandLock lock(options.out, "tactile reproduce");
  experiments::StepRunner runner({.folder = options.out,
                                  .program = options.program,
                                  .threads = options.threads,
                                  .new_progress = new_progress,
                                  .on_step = on_step,
                                  .slurm = options.slurm});
  const PreparedData prepared = prepare_data(options, runner, warn);
  const windows::Dataset dataset(prepared.dataset);
  const StudyPlan plan = plan_study(options, dataset, warn);
  const TrainedModels trained = train_models(plan, runner);
  const JudgedModels judged = judge_models(plan, trained, runner);
  const results::Study study = results_of(plan, trained, judged, prepared, runner.records());
  write_results(study, options.out);
  return {.study = study,
          .file = options.out / "study.json",
          .done = runner.done_now(),
          .kept = runner.kept(),
          .errors = prepared.errors};
}

}  // namespace tactile::study
