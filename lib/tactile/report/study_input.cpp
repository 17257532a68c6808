#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/json.hpp"
#include "tactile/report/input_parts.hpp"
#include "tactile/results/study.hpp"

namespace tactile::report {
namespace {

namespace fs = std::filesystem;

std::string seconds_text(double seconds) {
  if (!std::isfinite(seconds)) return "-";
  if (seconds < 120) return fmt::format("{:.1f} s", seconds);
  return fmt::format("{:.1f} min", seconds / 60);
}

void add_table(std::vector<ReportedTable>& tables, const std::string& caption, TableRow head, std::vector<TableRow> rows) {
  if (!rows.empty()) tables.push_back({.caption = caption, .head = std::move(head), .rows = std::move(rows)});
}

std::string name_of(const results::StudyWorld& world) { return world.name.empty() ? "-" : world.name; }

void read_left_out(ReportInput& input, const results::Study& study) {
  std::vector<TableRow> rows;
  for (const results::StudyWorld& world : study.worlds) {
    for (const results::LeftOut& one : world.left_out)
      rows.push_back({name_of(world), one.run, one.what == "run" ? "the whole run" : one.what, one.reason});
  }
  add_table(input.left_out, "Runs and intervals that are in no sample", {"world", "run", "what", "reason"}, std::move(rows));
}

void read_results(ReportInput& input, const results::Study& study) {
  std::vector<std::pair<double, results::Accuracy>> accuracies;
  for (const results::StudiedSetting& setting : study.results) {
    if (std::isfinite(setting.history_ms) && !setting.is_unseen) accuracies.emplace_back(setting.history_ms, setting.accuracy);
    if (!setting.whole_runs.runs.empty()) input.settings_on_whole_runs.push_back(setting);
  }
  // Streams first: they are what a robot acts on.
  std::stable_partition(input.settings_on_whole_runs.begin(), input.settings_on_whole_runs.end(),
                        [](const results::StudiedSetting& setting) { return setting.setting.starts_with("stream"); });
  if (!accuracies.empty()) input.histories.push_back(histories_of("all test runs", accuracies));
  for (const results::StudiedUnseen& unseen : study.unseen) {
    if (!unseen.accuracy.objects.empty())
      input.unseen.push_back({.name = unseen.text, .setting = unseen.setting, .runs = {}, .comparison = unseen.accuracy});
  }
  if (input.unseen.empty()) input.missing.push_back("Unseen objects (the paper's figure 11): none could be held out.");
}

void read_models(ReportInput& input, const results::Study& study, const fs::path& folder) {
  std::vector<TableRow> rows;
  for (const results::StudiedModel& model : study.models) {
    rows.push_back({model.name, name_of(study.worlds[model.world]), model.setting, model.train_run, std::to_string(model.seed),
                    model.weights_sha256.substr(0, 16)});
    if (model.world > 0 || model.training > 0) continue;  // one of each setting
    const fs::path file = folder / model.history;
    if (is_found(input, file, "The training of " + model.name)) input.trainings.push_back(training_in(file, model.name));
  }
  add_table(input.settings, "Models", {"model", "world", "setting", "training run", "seed", "weights, SHA-256"}, std::move(rows));
}

void read_runs(ReportInput& input, const results::Study& study, const fs::path& folder) {
  for (results::ReportedRun run : study.full_runs) {
    const fs::path csv = folder / run.csv;
    run.csv = csv.string();
    if (is_found(input, csv, "The full run " + run.run)) input.runs.push_back(std::move(run));
  }
  if (study.full_runs.empty())
    input.missing.push_back("No run over time (the paper's figure 10); 'tactile eval --run OBJECT/RUN' makes one.");
}

void read_settings(ReportInput& input, const results::Study& study) {
  std::vector<TableRow> settings, machine, worlds, steps;
  const nlohmann::json bootstrap = study.bootstrap;
  add_settings(settings, "", {study.settings, "settings"});
  add_settings(settings, "bootstrap ", {bootstrap, "bootstrap"});
  add_table(input.settings, "Settings and seeds", {"setting", "value"}, std::move(settings));
  for (const results::StudyWorld& world : study.worlds)
    worlds.push_back({name_of(world), std::to_string(world.runs), std::to_string(world.samples),
                      fmt::format("{}", fmt::join(world.held_out, ", ")), world.manifest_hash.substr(0, 16), world.data});
  add_table(input.settings, "Worlds", {"world", "runs", "samples", "held out", "dataset, SHA-256", "data"}, std::move(worlds));
  add_settings(machine, "", {study.software, "software"});
  add_settings(machine, "", {study.machine, "machine"});
  add_table(input.settings, "Software and machine", {"what", "value"}, std::move(machine));
  if (study.machine.is_null()) input.missing.push_back("The machine that measured is not recorded.");
  double total = 0;
  for (const results::StepRecord& step : study.steps) {
    steps.push_back({step.name, seconds_text(step.seconds), step.finished_at, step.command.empty() ? "-" : step.command});
    if (std::isfinite(step.seconds)) total += step.seconds;
  }
  if (!steps.empty()) steps.push_back({"sum over all steps, some of them at the same time", seconds_text(total), "", ""});
  add_table(input.settings, "Steps and their times", {"step", "duration", "finished (UTC)", "equivalent command"},
            std::move(steps));
}

}  // namespace

ReportInput read_study(const fs::path& folder) {
  const results::Study study = results::read_study(folder);
  ReportInput input;
  input.title = study.title;
  input.simulated = study.simulated;
  input.found = study.found;
  input.claims = study.claims;
  if (!study.worlds.empty()) input.data = folder / study.worlds.front().data;
  if (!study.intervals.empty()) input.remarks.push_back(study.intervals);
  add_sentences(input.remarks, study.remarks);
  read_left_out(input, study);
  read_results(input, study);
  read_runs(input, study, folder);
  read_settings(input, study);
  read_models(input, study, folder);
  return input;
}

}  // namespace tactile::report
