#include "tactile/experiments/study/study_results.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <tuple>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/baselines.hpp"
#include "tactile/evaluation/other_runs.hpp"
#include "tactile/evaluation/whole_runs.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/study/claims.hpp"
#include "tactile/experiments/study/judge_models.hpp"
#include "tactile/experiments/study/left_out.hpp"
#include "tactile/results/found.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* cells_name = "cells.csv";

std::string path_in(const StudyPlan& plan, const fs::path& path) { return experiments::from_folder(path, plan.options.out); }

std::vector<results::StudyWorld> worlds_in(const StudyPlan& plan) {
  std::vector<results::StudyWorld> worlds;
  for (const StudiedWorld& world : plan.worlds) {
    const fs::path& data = world.prepared.world.data;
    worlds.push_back({.name = world.prepared.world.name,
                      .data = path_in(plan, data),
                      .manifest_hash = world.dataset->manifest_hash(),
                      .runs = world.dataset->runs().size(),
                      .samples = world.dataset->samples().size(),
                      .held_out = world.held_out,
                      .left_out = left_out_of(*world.dataset, is_there(data) ? find_runs(data) : std::vector<RunFolder>{})});
  }
  return worlds;
}

std::vector<results::StudiedModel> models_in(const StudyPlan& plan) {
  std::vector<results::StudiedModel> models;
  for (const StudyModel& model : plan.models) {
    models.push_back({.world = model.world,
                      .training = model.training,
                      .setting = model.setting,
                      .name = model.name(),
                      .folder = path_in(plan, model.bundle.folder),
                      .history = path_in(plan, model.bundle.history()),
                      .train_run = model.settings.split.train_run,
                      .seed = model.settings.training.seed,
                      .weights_sha256 = model::read_description(model.bundle).weights_sha256});
  }
  return models;
}

json settings_json(const StudyPlan& plan) {
  const StudyOptions& options = plan.options;
  const windows::Dataset& dataset = *plan.worlds.front().dataset;
  json histories = json::array();
  for (const microseconds history : options.histories) histories.push_back(in_ms(history));
  const bool simulated = plan.worlds.front().prepared.simulated;
  return {{"data", path_in(plan, options.data)},
          {"models", path_in(plan, options.models)},
          {"preset", options.preset},
          {"seed", options.seed},
          {"worlds", plan.worlds.size()},
          {"trainings", *options.trainings},
          {"train_run", options.train_run},
          {"histories_ms", histories},
          {"epochs", *options.epochs},
          {"steps", *options.steps},
          {"engine", name_of(options.engine)},
          {"include_flagged", options.include_flagged},
          {"tick_ms", in_ms(dataset.sampling().tick)},
          {"guard_ms", in_ms(dataset.sampling().guard)},
          {"objects", simulated && !options.objects.empty() ? json(options.objects) : json()},
          {"runs", simulated && options.runs ? json(*options.runs) : json()}};
}

/// What confidence intervals include, and what they do not.
std::string sentence_on_intervals(std::size_t worlds, unsigned trainings) {
  const std::string each = trainings == 1 ? std::string("one training") : fmt::format("{} trainings", trainings);
  if (worlds >= evaluation::fewest_worlds)
    return fmt::format(
        "{} worlds, each with objects and a sensor of its own, and {} of each setting in each. Intervals are over worlds.",
        worlds, each);
  if (trainings == 1) return "One training of each setting: intervals are over runs and objects, not over trainings.";
  if (trainings == 2) return "Two trainings give no intervals: take three or more.";
  return fmt::format(
      "{} trainings of each setting, each on another run and with another seed. None is judged on a run that it learned from. "
      "Intervals are over trainings, objects and runs.",
      trainings);
}

std::string text_of(const StudyModel& model) {
  std::string text = model.settings.kind == model::ModelKind::stream
                         ? std::string("stream")
                         : fmt::format("LeNet, t_h {} ms", experiments::ms_text(model.settings.rendering.history));
  return model.settings.split.kind == windows::SplitKind::unseen ? text + ", objects never seen" : text;
}

/// Runs that no model of a setting could be judged on, in all worlds.
std::vector<results::LeftOutRun> left_out_by(const StudyPlan& plan, const std::string& setting) {
  std::vector<results::LeftOutRun> left_out;
  for (const StudyModel& model : plan.models) {
    if (model.setting != setting || model.training != 0) continue;
    const std::string& world = plan.worlds[model.world].prepared.world.name;
    for (results::LeftOutRun run : evaluation::other_runs(plan.dataset(model), model.runs, model.settings.split).left_out) {
      if (!run.run.empty() && !world.empty()) run.run = fmt::format("world {}, {}", world, run.run);
      left_out.push_back(std::move(run));
    }
  }
  return left_out;
}

std::vector<results::Cell> of_setting(std::span<const results::Cell> cells, const std::string& setting) {
  std::vector<results::Cell> chosen;
  std::copy_if(cells.begin(), cells.end(), std::back_inserter(chosen),
               [&](const results::Cell& cell) { return cell.setting == setting; });
  return chosen;
}

/// The verdicts as they were decided, on runs with samples.
std::vector<results::Cell> sampled(std::span<const results::Cell> cells) {
  std::vector<results::Cell> chosen;
  std::copy_if(cells.begin(), cells.end(), std::back_inserter(chosen),
               [](const results::Cell& cell) { return !cell.threshold && !cell.confirmed && evaluation::has_samples(cell); });
  return chosen;
}

std::vector<results::StudiedSetting> settings_in(const StudyPlan& plan, std::span<const results::Cell> cells,
                                                 const results::BootstrapOptions& bootstrap) {
  std::vector<results::StudiedSetting> settings;
  for (const StudyModel& model : plan.models) {
    if (model.world != 0 || model.training != 0) continue;
    const std::vector<results::Cell> own = of_setting(cells, model.setting);
    results::StudiedSetting& setting = settings.emplace_back();
    setting.setting = model.setting;
    setting.text = text_of(model);
    setting.is_unseen = model.settings.split.kind == windows::SplitKind::unseen;
    if (model.settings.kind == model::ModelKind::lenet) setting.history_ms = in_ms(model.settings.rendering.history);
    setting.accuracy = evaluation::accuracy_of(sampled(own), bootstrap);
    if (!model.whole) continue;
    setting.whole_runs = evaluation::whole_runs(own, plan.options.threads, bootstrap);
    setting.whole_runs.left_out = left_out_by(plan, model.setting);
    for (const char* name : evaluation::baseline_names) {
      if (!judges_baselines(model)) break;
      const std::vector<results::Cell> of_baseline = of_setting(cells, setting_of_baseline(name, model));
      if (!of_baseline.empty()) setting.baselines[name] = evaluation::baseline_of(of_baseline, plan.options.threads, bootstrap);
    }
  }
  return settings;
}

/// The runs that the models with and without their objects were both judged on.
results::UnseenComparison compared(std::span<const results::Cell> seen, std::span<const results::Cell> held_out,
                                   const results::BootstrapOptions& bootstrap) {
  const auto key_of = [](const results::Cell& cell) { return std::tie(cell.world, cell.object, cell.run, cell.training); };
  std::vector<results::Cell> with, without;
  for (const results::Cell& cell : held_out) {
    const auto found =
        std::find_if(seen.begin(), seen.end(), [&](const results::Cell& other) { return key_of(other) == key_of(cell); });
    if (found == seen.end()) continue;
    with.push_back(*found);
    without.push_back(cell);
  }
  return evaluation::unseen_comparison(with, without, bootstrap);
}

std::vector<results::StudiedUnseen> unseen_in(std::span<const results::StudiedSetting> settings,
                                              std::span<const results::Cell> cells, const results::BootstrapOptions& bootstrap) {
  std::vector<results::StudiedUnseen> unseen;
  for (const results::StudiedSetting& setting : settings) {
    if (!setting.is_unseen) continue;
    const std::string seen = setting.setting.substr(0, setting.setting.rfind('-'));
    const std::string text = setting.text.substr(0, setting.text.rfind(','));
    unseen.push_back(
        {seen, text, compared(sampled(of_setting(cells, seen)), sampled(of_setting(cells, setting.setting)), bootstrap)});
  }
  return unseen;
}

}  // namespace

results::Study results_of(const StudyPlan& plan, std::span<const results::Cell> cells, std::vector<results::ReportedRun> runs,
                          std::vector<results::StepRecord> steps) {
  const bool simulated = plan.worlds.front().dataset->simulated();
  results::Study study{
      .title = fmt::format("The paper's study on {} runs ({})", simulated ? "simulated" : "real", plan.options.preset),
      .simulated = simulated,
      .settings = settings_json(plan),
      .software = experiments::software_json(),
      .machine = experiments::machine_json(plan.options.threads),
      .intervals = sentence_on_intervals(plan.worlds.size(), *plan.options.trainings),
      .steps = std::move(steps),
      .worlds = worlds_in(plan),
      .models = models_in(plan),
      .cells = cells_name,
      .full_runs = std::move(runs),
      .claims = claims_of(cells, main_history(plan.options)),
      .remarks = plan.remarks};
  study.results = settings_in(plan, cells, study.bootstrap);
  study.unseen = unseen_in(study.results, cells, study.bootstrap);
  study.found = results::found_in(study);
  study.found.push_back(summary_of(study.claims, simulated));
  return study;
}

void write_results(const results::Study& study, std::span<const results::Cell> cells, const fs::path& folder) {
  write_whole(folder / cells_name, results::cells_csv(cells));
  write_whole(folder / "study.json", json_text(json(study), 2) + "\n");
}

}  // namespace tactile::study
