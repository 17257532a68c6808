#include "tactile/experiments/stress/estimate_stress.hpp"

#include <map>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/stress/stress_judgements.hpp"
#include "tactile/experiments/training_speed.hpp"

namespace tactile::stress {
namespace {

/// What one judgement reads.
struct Work {
  double ticks = 0, seconds = 0;
};

Work work_of(const StressPlan& plan, const StressJudgement& judgement) {
  const heatmaps::HeatmapOptions& rendering = judgement.training->description.settings.rendering;
  Work work;
  const auto add = [&](const std::filesystem::path& recording) {
    work.ticks += static_cast<double>(evaluation::expected_ticks(recording, rendering));
  };
  if (judgement.runs == JudgedRuns::quiet) {
    for (const auto& file : plan.options.quiet) add(file);
  } else {
    for (const RunFolder& run : judgement.training->folders()) add(run.events());
  }
  work.seconds = work.ticks * in_s(rendering.tick);
  return work;
}

}  // namespace

experiments::Estimate estimate_stress(const StressOptions& requested) {
  StressOptions options = requested;
  options.judging.threads = threads_or_all(options.judging.threads);
  const StressPlan plan = plan_stress(options);
  const experiments::StepRunner runner({.folder = options.out, .program = options.program});
  experiments::Estimate estimate{
      .parts = {}, .cores = options.judging.threads, .images_per_s = experiments::measured_training_speed(), .data = "the runs"};
  const experiments::WorkCost cost = experiments::work_cost(estimate.images_per_s);
  const std::vector<StressJudgement> judgements = judgements_of(plan);
  const std::vector<experiments::Step> steps = steps_of(plan);  // one for each
  experiments::EstimatedPart worsened{.what = "judgements of worsened runs", .one_thread = true},
      simulated{.what = "judgements of runs of simulated worlds", .one_thread = true};
  // All judgements of a training read the same runs.
  std::map<std::pair<const StressTraining*, bool>, Work> known;
  for (std::size_t i = 0; i < judgements.size(); ++i) {
    const StressJudgement& judgement = judgements[i];
    const auto [found, is_new] = known.try_emplace({judgement.training, judgement.runs == JudgedRuns::quiet});
    if (is_new) found->second = work_of(plan, judgement);
    const Work& work = found->second;
    const bool is_world = judgement.series != nullptr && !judgement.series->world.empty();
    experiments::EstimatedPart& part = is_world ? simulated : worsened;
    ++part.count;
    if (!options.force && runner.is_done(steps[i])) {
      ++part.exist;
      continue;
    }
    part.seconds += cost.stressed_tick * work.ticks;
    if (!is_world) continue;
    part.seconds += cost.simulated_second * work.seconds;
    part.bytes += experiments::bytes_of_second * work.seconds;
  }
  for (const experiments::EstimatedPart& part : {worsened, simulated}) {
    if (part.count > 0) estimate.parts.push_back(part);
  }
  return estimate;
}

}  // namespace tactile::stress
