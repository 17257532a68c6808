#include "tactile/experiments/stress/plan_stress.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::stress {
namespace {

StressTraining training_of(const StressPlan& plan, const std::filesystem::path& folder) {
  StressTraining training{.bundle = {folder}, .description = model::read_description({folder}), .runs = {}};
  if (!plan.dataset) return training;
  const windows::Dataset& dataset = *plan.dataset;
  const model::Classifier classifier = model::open_classifier(folder, 1, plan.options.engine);
  evaluation::EvaluationOptions options = plan.options.judging;
  options.of_another_dataset = training.description.manifest_hash != dataset.manifest_hash();
  evaluation::check_fits(dataset, classifier, options);
  training.runs = model::test_runs_of(dataset, training.description);
  evaluation::leave_out_calibration_runs(training.runs, dataset, classifier);
  std::erase_if(training.runs, [&](std::uint32_t run) { return evaluation::samples_in(dataset, run).empty(); });
  if (plan.options.runs) training.runs = first_of_each_object(dataset, training.runs, *plan.options.runs);
  return training;
}

void check_ticks(const StressPlan& plan) {
  const StressTraining& first = plan.groups.front().trainings.front();
  for (const StressGroup& group : plan.groups) {
    for (const StressTraining& training : group.trainings) {
      const microseconds tick = training.description.settings.rendering.tick,
                         expected = first.description.settings.rendering.tick;
      if (tick != expected)
        throw Error(fmt::format("{}: a tick of {} us; expected {} us as {} has", training.bundle.folder.string(), tick.count(),
                                expected.count(), first.bundle.folder.string()));
    }
  }
}

}  // namespace

bool are_trainings_of_one(const model::ModelDescription& a, const model::ModelDescription& b) {
  const auto without_draws = [](model::ModelSettings settings) {
    settings.training.seed = 0;
    settings.split.train_run.clear();
    return settings;
  };
  return a.manifest_hash == b.manifest_hash && model::same_settings(without_draws(a.settings), without_draws(b.settings));
}

std::vector<std::uint32_t> first_of_each_object(const windows::Dataset& dataset, std::vector<std::uint32_t> runs, unsigned most) {
  std::map<std::string, unsigned> taken;
  std::erase_if(runs, [&](std::uint32_t run) { return ++taken[dataset.runs()[run].object] > most; });
  return runs;
}

StressPlan plan_stress(const StressOptions& options) {
  StressPlan plan{.options = options, .dataset = {}, .groups = {}};
  if (options.models.empty()) throw Error("no model to stress; expected one at least");
  if (options.series.empty()) throw Error("no recipe to apply; expected one at least");
  if (options.dataset) plan.dataset.emplace(*options.dataset);
  std::set<std::filesystem::path> given;
  for (const std::filesystem::path& folder : options.models) {
    if (!given.insert(std::filesystem::weakly_canonical(folder)).second)
      throw Error(folder.string() + ": this model is given twice; expected each once");
    StressTraining training = training_of(plan, folder);
    const auto group = std::find_if(plan.groups.begin(), plan.groups.end(), [&](const StressGroup& one) {
      return are_trainings_of_one(one.trainings.front().description, training.description);
    });
    if (group == plan.groups.end())
      plan.groups.push_back({training.bundle.name(), {training}});
    else
      group->trainings.push_back(training);
  }
  check_ticks(plan);
  std::set<std::uint32_t> runs;
  for (const StressGroup& group : plan.groups) {
    for (const StressTraining& training : group.trainings) runs.insert(training.runs.begin(), training.runs.end());
  }
  for (const std::uint32_t run : runs) windows::check_unchanged(*plan.dataset, run);
  if (runs.empty() && options.quiet.empty())
    throw Error("nothing to judge on; expected a dataset with runs that no model learned from, or --quiet with recordings");
  return plan;
}

}  // namespace tactile::stress
