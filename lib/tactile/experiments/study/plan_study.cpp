#include "tactile/experiments/study/plan_study.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/core/runs_below.hpp"
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

std::vector<std::string> all_remarks(const StudyOptions& options, const windows::Dataset& dataset,
                                     const experiments::RunDivision& runs) {
  const windows::SplitOptions single{.kind = windows::SplitKind::single_run, .train_run = options.train_run};
  const model::SplitRemarks split = model::remarks_on(dataset, single, model::split_of(dataset, single));
  std::vector<std::string> remarks;
  for (const auto& sentences : {split.substitutes, split.left_out, experiments::remarks_on(dataset, runs)})
    remarks.insert(remarks.end(), sentences.begin(), sentences.end());
  return remarks;
}

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
  const experiments::RunDivision runs =
      experiments::divide_runs(dataset, options.train_run, preset_settings(options.preset).choice_runs);
  StudyPlan plan{.options = options,
                 .dataset = dataset,
                 .train = runs.train,
                 .choice = {"choice", runs.choice, names_of(dataset, runs.choice)},
                 .reported = {"reported", runs.reported, names_of(dataset, runs.reported)},
                 .all_test = {"all_test", runs.all_test, names_of(dataset, runs.all_test)},
                 .objects = {},
                 .held_out = {},
                 .splits = {},
                 .remarks = all_remarks(options, dataset, runs)};
  if (warn) std::for_each(plan.remarks.begin(), plan.remarks.end(), warn);
  std::set<std::string> objects;
  for (const std::uint32_t run : runs.train) objects.insert(dataset.runs()[run].object);
  plan.objects.assign(objects.begin(), objects.end());
  plan.held_out = objects_to_hold_out(options.held_out, plan.objects, dataset);
  if (options.splits == 0) return plan;
  if (plan.held_out.empty())
    throw Error("--splits: no objects to hold out of training; expected some of --held-out in the dataset");
  plan.splits = drawn_splits(all_splits(plan.objects, plan.held_out.size()), options.splits, options.seed);
  return plan;
}

StudyModel model_of(const StudyPlan& plan, microseconds history, std::uint64_t seed, const std::vector<std::string>& held_out) {
  const StudyOptions& options = plan.options;
  StudyModel model;
  model.settings.rendering.history = history;
  model.settings.training.seed = seed;
  model.settings.training.epochs = *options.epochs;
  model.settings.training.engine = options.engine;
  model.settings.split.train_run = options.train_run;
  if (!held_out.empty()) model.settings.split = {windows::SplitKind::unseen, options.train_run, held_out};
  model.bundle = {options.models / model::default_name(model.settings)};
  for (const std::uint32_t run : plan.all_test.runs) {
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
