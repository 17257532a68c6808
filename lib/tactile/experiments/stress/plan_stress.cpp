#include "tactile/experiments/stress/plan_stress.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/evaluation/other_runs.hpp"
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
  std::vector<std::uint32_t> sampled = model::test_runs_of(dataset, training.description);
  evaluation::leave_out_calibration_runs(sampled, dataset, classifier);
  std::erase_if(sampled, [&](std::uint32_t run) { return evaluation::samples_in(dataset, run).empty(); });
  for (const std::uint32_t run : sampled) training.runs.push_back({evaluation::folder_of(dataset, run), run});
  evaluation::OtherRuns others = evaluation::other_runs(dataset, sampled, training.description);
  for (const RunFolder& run : others.runs) training.runs.push_back({run});
  training.left_out = std::move(others.left_out);
  if (plan.options.runs) training.runs = first_of_each_object(training.runs, *plan.options.runs);
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

std::vector<RunFolder> StressTraining::folders() const {
  std::vector<RunFolder> folders;
  for (const StressedRun& run : runs) folders.push_back(run.folder);
  return folders;
}

std::vector<std::string> StressTraining::names() const {
  std::vector<std::string> names;
  for (const StressedRun& run : runs) names.push_back(run.folder.name());
  return names;
}

std::vector<StressedRun> first_of_each_object(std::vector<StressedRun> runs, unsigned most) {
  std::map<std::string, unsigned> taken;
  std::erase_if(runs, [&](const StressedRun& run) { return ++taken[run.folder.object] > most; });
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
  std::set<std::uint32_t> sampled;
  for (const StressGroup& group : plan.groups) {
    for (const StressTraining& training : group.trainings) {
      for (const StressedRun& run : training.runs) {
        if (run.index) sampled.insert(*run.index);
      }
    }
  }
  for (const std::uint32_t run : sampled) windows::check_unchanged(*plan.dataset, run);
  if (sampled.empty() && options.quiet.empty())
    throw Error("nothing to judge on; expected a dataset with runs that no model learned from, or --quiet with recordings");
  return plan;
}

}  // namespace tactile::stress
