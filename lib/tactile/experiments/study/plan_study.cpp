#include "tactile/experiments/study/plan_study.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/models_folder.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/model/training/split_remarks.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/without_samples.hpp"

namespace tactile::study {
namespace {

/// In each call, because the step that leaves runs out may be kept.
void warn_of_runs_without_samples(const StudyOptions& options, const StudiedWorld& world, const WarningCallback& warn) {
  const std::vector<RunFolder> runs = find_runs(world.prepared.world.data);
  const std::vector<windows::RunWithoutSamples> without = windows::runs_without_samples(*world.dataset, runs);
  if (options.strict)
    windows::refuse_objects_left_out(windows::objects_left_out(windows::runs_of_objects_left_out(*world.dataset), {}));
  if (!without.empty() && warn) warn(windows::sentence_on(without, runs.size(), world.prepared.world.data, "tactile reproduce"));
}

/// Each once: most hold for several trainings.
void add_remarks(std::vector<std::string>& remarks, const StudiedWorld& world, const PlannedTraining& training,
                 const experiments::RunDivision& runs) {
  const windows::Dataset& dataset = *world.dataset;
  const windows::SplitOptions single{.kind = windows::SplitKind::single_run, .train_run = training.train_run};
  const model::SplitRemarks split = model::remarks_on(dataset, single, model::split_of(dataset, single));
  const std::string& name = world.prepared.world.name;
  for (const auto& sentences : {split.substitutes, split.left_out, experiments::remarks_on(dataset, runs)}) {
    for (const std::string& sentence : sentences) {
      const std::string remark = name.empty() ? sentence : fmt::format("world {}, {}", name, sentence);
      if (std::find(remarks.begin(), remarks.end(), remark) == remarks.end()) remarks.push_back(remark);
    }
  }
}

/// The objects that are trained on, by name.
std::vector<std::string> objects_of(const windows::Dataset& dataset, const experiments::RunDivision& runs) {
  std::set<std::string> objects;
  for (const std::uint32_t run : runs.train) objects.insert(dataset.runs()[run].object);
  return {objects.begin(), objects.end()};
}

/// @throws Error  if one of them has no training run, or nothing would be left to learn from
void check_held_out(const std::vector<std::string>& requested, const std::vector<std::string>& objects,
                    const windows::Dataset& dataset) {
  std::set<std::string> without_samples;
  for (const windows::RunWithoutSamples& run : windows::runs_of_objects_left_out(dataset)) without_samples.insert(run.object);
  std::size_t found = 0;
  for (const std::string& object : requested) {
    const bool is_trained = std::find(objects.begin(), objects.end(), object) != objects.end();
    found += is_trained ? 1 : 0;
    if (!is_trained && !without_samples.contains(object)) {
      throw Error(
          fmt::format("held-out object '{}': no training run of it; expected some of {}", object, fmt::join(objects, ", ")));
    }
  }
  if (found == 0) {
    throw Error(fmt::format("held-out objects {}: none of them has a run with samples; expected some of {}",
                            fmt::join(requested, ", "), fmt::join(objects, ", ")));
  }
  if (found == objects.size()) {
    throw Error(fmt::format("held-out objects {}: nothing is left to learn from; expected fewer than there are",
                            fmt::join(requested, ", ")));
  }
}

/// By name. @param others  hold out those that are not named
std::vector<std::string> objects_to_hold_out(const StudyOptions& options, const std::vector<std::string>& objects,
                                             const windows::Dataset& dataset, bool others) {
  if (!options.held_out.empty()) check_held_out(options.held_out, objects, dataset);
  const std::vector<std::string>& named = options.held_out.empty() ? windows::default_held_out() : options.held_out;
  std::vector<std::string> held_out;
  for (const std::string& object : objects) {
    const bool is_named = std::find(named.begin(), named.end(), object) != named.end();
    if (is_named != (others && options.held_out.empty())) held_out.push_back(object);
  }
  return held_out.size() < objects.size() ? held_out : std::vector<std::string>{};
}

/// @param held_out  objects left out of training; it is judged on their test runs only. Empty: on all test runs
StudyModel model_of(const StudyPlan& plan, std::size_t world, std::size_t training, model::ModelKind kind, microseconds history,
                    const std::vector<std::string>& held_out = {}) {
  const StudyOptions& options = plan.options;
  const windows::Dataset& dataset = *plan.worlds[world].dataset;
  const PlannedTraining& planned = plan.worlds[world].trainings[training];
  StudyModel model{.world = world, .training = training};
  model.settings.kind = kind;
  // A stream reads each tick once, and remembers.
  heatmaps::HeatmapOptions& rendering = model.settings.rendering;
  rendering.history = kind == model::ModelKind::stream ? rendering.tick : history;
  model.settings.training.seed = planned.seed;
  model.settings.training.epochs = *options.epochs;
  model.settings.training.engine = options.engine;
  model.settings.stream.steps = *options.steps;
  model.settings.split.train_run = planned.train_run;
  if (!held_out.empty()) model.settings.split = {windows::SplitKind::unseen, planned.train_run, held_out};
  model.setting = setting_name(model.settings);
  model.bundle = experiments::training_bundle(options.models, options.out, model.settings, dataset.manifest_hash());
  for (const std::uint32_t run : planned.test) {
    const std::string& object = dataset.runs()[run].object;
    if (held_out.empty() || std::find(held_out.begin(), held_out.end(), object) != held_out.end()) model.runs.push_back(run);
  }
  model.whole = kind == model::ModelKind::stream || history == main_history(options);
  return model;
}

void add_models(StudyPlan& plan, std::size_t world, std::size_t training) {
  for (const microseconds history : plan.options.histories)
    plan.models.push_back(model_of(plan, world, training, model::ModelKind::lenet, history));
  const auto add = [&](model::ModelKind kind, const std::vector<std::string>& held_out) {
    plan.models.push_back(model_of(plan, world, training, kind, main_history(plan.options), held_out));
  };
  add(model::ModelKind::stream, {});
  const std::vector<std::string>& held_out = plan.worlds[world].held_out;
  if (held_out.empty()) return;
  add(model::ModelKind::lenet, held_out);
  add(model::ModelKind::stream, held_out);
}

}  // namespace

std::string setting_name(const model::ModelSettings& settings) {
  std::string name = "stream";
  if (settings.kind != model::ModelKind::stream) {
    const std::string ms = experiments::ms_text(settings.rendering.history);
    const std::size_t whole = std::min(ms.find('.'), ms.size());
    name = "th" + std::string(whole < 3 ? 3 - whole : 0, '0') + ms;
  }
  return settings.split.kind == windows::SplitKind::unseen ? name + "-unseen" : name;
}

StudyPlan plan_study(const StudyOptions& options, std::vector<PreparedWorld> worlds, const WarningCallback& warn) {
  StudyPlan plan{.options = options, .worlds = {}, .models = {}, .remarks = {}};
  for (PreparedWorld& prepared : worlds) {
    StudiedWorld& world = plan.worlds.emplace_back();
    world.prepared = std::move(prepared);
    world.dataset = std::make_unique<const windows::Dataset>(world.prepared.dataset);
    warn_of_runs_without_samples(options, world, warn);
    for (unsigned k = 0; k < *options.trainings; ++k) {
      const experiments::RunDivision runs = experiments::rotated_division(*world.dataset, options.train_run, {}, k);
      world.trainings.push_back({.seed = world.prepared.world.seed + k,
                                 .train_run = experiments::rotated_run(*world.dataset, options.train_run, k),
                                 .test = runs.all_test});
      add_remarks(plan.remarks, world, world.trainings.back(), runs);
      if (k == 0) {
        const bool is_second = plan.worlds.size() % 2 == 0;
        world.held_out = objects_to_hold_out(options, objects_of(*world.dataset, runs), *world.dataset, is_second);
      }
    }
  }
  if (warn) std::for_each(plan.remarks.begin(), plan.remarks.end(), warn);
  for (std::size_t world = 0; world < plan.worlds.size(); ++world) {
    for (std::size_t training = 0; training < plan.worlds[world].trainings.size(); ++training) add_models(plan, world, training);
  }
  return plan;
}

}  // namespace tactile::study
