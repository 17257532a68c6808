#include "tactile/experiments/study/plan_study.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/experiments/models_folder.hpp"
#include "tactile/model/training/split_remarks.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/without_samples.hpp"

namespace tactile::study {
namespace {

/// In each call, because the step that leaves runs out may be kept.
void warn_of_runs_without_samples(const StudyOptions& options, const windows::Dataset& dataset, const WarningCallback& warn) {
  const std::vector<RunFolder> runs = is_there(options.data) ? find_runs(options.data) : std::vector<RunFolder>{};
  const std::vector<windows::RunWithoutSamples> without = windows::runs_without_samples(dataset, runs);
  if (options.strict) windows::refuse_objects_left_out(windows::objects_left_out(windows::runs_of_objects_left_out(dataset), {}));
  if (!without.empty() && warn) warn(windows::sentence_on(without, runs.size(), options.data, "tactile reproduce"));
}

/// Each once: most hold for several trainings.
std::vector<std::string> all_remarks(const windows::Dataset& dataset, std::span<const PlannedTraining> trainings,
                                     std::span<const experiments::RunDivision> divisions) {
  std::vector<std::string> remarks;
  for (std::size_t k = 0; k < trainings.size(); ++k) {
    const windows::SplitOptions single{.kind = windows::SplitKind::single_run, .train_run = trainings[k].train_run};
    const model::SplitRemarks split = model::remarks_on(dataset, single, model::split_of(dataset, single));
    for (const auto& sentences : {split.substitutes, split.left_out, experiments::remarks_on(dataset, divisions[k])}) {
      for (const std::string& sentence : sentences) {
        if (std::find(remarks.begin(), remarks.end(), sentence) == remarks.end()) remarks.push_back(sentence);
      }
    }
  }
  return remarks;
}

RunSet set_of(const windows::Dataset& dataset, const std::vector<std::uint32_t>& runs) { return {runs, names_of(dataset, runs)}; }

/// Those requested, or those of the paper that are among `objects`; by name.
std::vector<std::string> objects_to_hold_out(const std::vector<std::string>& requested, const std::vector<std::string>& objects,
                                             const windows::Dataset& dataset) {
  std::set<std::string> without_samples;
  for (const windows::RunWithoutSamples& run : windows::runs_of_objects_left_out(dataset)) without_samples.insert(run.object);
  std::vector<std::string> held_out;
  for (const std::string& object : requested.empty() ? windows::default_held_out() : requested) {
    if (std::find(objects.begin(), objects.end(), object) != objects.end()) {
      held_out.push_back(object);
    } else if (!requested.empty() && !without_samples.contains(object)) {
      throw Error(
          fmt::format("held-out object '{}': no training run of it; expected some of {}", object, fmt::join(objects, ", ")));
    }
  }
  std::sort(held_out.begin(), held_out.end());
  if (held_out.empty() && !requested.empty()) {
    throw Error(fmt::format("held-out objects {}: none of them has a run with samples; expected some of {}",
                            fmt::join(requested, ", "), fmt::join(objects, ", ")));
  }
  if (held_out.size() < objects.size()) return held_out;
  if (!requested.empty()) {
    throw Error(fmt::format("held-out objects {}: nothing is left to learn from; expected fewer than there are",
                            fmt::join(held_out, ", ")));
  }
  return {};
}

}  // namespace

StudyPlan plan_study(const StudyOptions& options, const windows::Dataset& dataset, const WarningCallback& warn) {
  warn_of_runs_without_samples(options, dataset, warn);
  std::vector<std::string> choice_runs;
  for (std::size_t i = 1; i <= preset_settings(options.preset).choice_runs; ++i)
    choice_runs.push_back(experiments::rotated_run(dataset, options.train_run, i));
  StudyPlan plan{
      .options = options, .dataset = dataset, .trainings = {}, .objects = {}, .held_out = {}, .splits = {}, .remarks = {}};
  std::vector<experiments::RunDivision> divisions;
  for (unsigned k = 0; k < *options.trainings; ++k) {
    const experiments::RunDivision& runs =
        divisions.emplace_back(experiments::rotated_division(dataset, options.train_run, choice_runs, k));
    plan.trainings.push_back({.seed = options.seed + k,
                              .train_run = experiments::rotated_run(dataset, options.train_run, k),
                              .train = set_of(dataset, runs.train),
                              .choice = set_of(dataset, runs.choice),
                              .reported = set_of(dataset, runs.reported),
                              .all_test = set_of(dataset, runs.all_test)});
  }
  plan.remarks = all_remarks(dataset, plan.trainings, divisions);
  if (warn) std::for_each(plan.remarks.begin(), plan.remarks.end(), warn);
  std::set<std::string> objects;
  for (const std::uint32_t run : plan.trainings.front().train.runs) objects.insert(dataset.runs()[run].object);
  plan.objects.assign(objects.begin(), objects.end());
  const std::vector<std::string> together = objects_to_hold_out(options.held_out, plan.objects, dataset);
  if (options.hold_out_each && plan.objects.size() > 1) {
    for (const std::string& object : plan.objects) plan.held_out.push_back({object});
  } else if (!together.empty()) {
    plan.held_out.push_back(together);
  }
  if (together.empty() && *options.splits != preset_settings(options.preset).splits)
    throw Error("--splits: no objects to hold out of training; expected some of --held-out in the dataset");
  if (*options.splits > 0 && !together.empty())
    plan.splits = drawn_splits(all_splits(plan.objects, together.size()), *options.splits, options.seed);
  return plan;
}

StudyModel model_of(const StudyPlan& plan, microseconds history, std::size_t training, const std::vector<std::string>& held_out) {
  const StudyOptions& options = plan.options;
  const PlannedTraining& planned = plan.trainings[training];
  StudyModel model;
  model.training = training;
  model.settings.rendering.history = history;
  model.settings.training.seed = planned.seed;
  model.settings.training.epochs = *options.epochs;
  model.settings.training.engine = options.engine;
  model.settings.split.train_run = planned.train_run;
  if (!held_out.empty()) model.settings.split = {windows::SplitKind::unseen, planned.train_run, held_out};
  model.bundle = experiments::training_bundle(options.models, options.out, model.settings, plan.dataset.manifest_hash());
  for (const std::uint32_t run : planned.all_test.runs) {
    const std::string& object = plan.dataset.runs()[run].object;
    if (held_out.empty() || std::find(held_out.begin(), held_out.end(), object) != held_out.end()) model.runs.push_back(run);
  }
  return model;
}

nlohmann::json with_engine(nlohmann::json inputs, model::EngineKind engine) {
  if (engine != model::EngineKind::fast) inputs["engine"] = name_of(engine);
  return inputs;
}

}  // namespace tactile::study
