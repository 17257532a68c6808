#include "tactile/experiments/study/prepare_data.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/training_step.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/heatmaps/store_heatmaps.hpp"
#include "tactile/labels/label_runs.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/simulation/simulate.hpp"
#include "tactile/windows/dataset_settings.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr microseconds shortest_stored{50'000};  ///< of events before each sample, the default of `windows`

json size_of(const fs::path& file) {
  std::error_code missing;
  const auto size = fs::file_size(file, missing);
  return missing ? json() : json(size);
}

/// Size and modification time: they show a change of a file that is too large to be hashed each time.
json state_of_file(const fs::path& file) {
  std::error_code missing;
  const auto changed = fs::last_write_time(file, missing);
  return missing ? json() : json::array({size_of(file), changed.time_since_epoch().count()});
}

/// All runs' files as the simulator writes them; null if there are no runs.
json simulated_files(const fs::path& data) {
  json files;
  if (!is_there(data)) return files;
  for (const RunFolder& run : find_runs(data)) {
    files[run.name()] = {size_of(run.events()),      size_of(run.robot()), size_of(run.video()),
                         size_of(run.video_times()), size_of(run.truth()), experiments::hash_of_file(run.info())};
  }
  return files;
}

experiments::Step simulation_step(const StudyOptions& options, const World& world) {
  std::vector<std::string> words{"simulate", world.data.string(),       "--preset", options.preset,
                                 "--seed",   std::to_string(world.seed)};
  if (!options.objects.empty()) words.insert(words.end(), {"--objects", fmt::format("{}", fmt::join(options.objects, ","))});
  if (options.runs) words.insert(words.end(), {"--runs", std::to_string(*options.runs)});
  return {.name = "simulate" + world.suffix(),
          .command = experiments::command_of(words),
          .inputs = {{"data", experiments::from_folder(world.data, options.out)},
                     {"preset", options.preset},
                     {"objects", options.objects},
                     {"runs", options.runs ? json(*options.runs) : json()},
                     {"seed", world.seed}},
          .outputs = [data = world.data] { return simulated_files(data); },
          .work =
              [options, world](const ProgressCallback& progress) {
                simulation::simulate({.data = world.data,
                                      .preset = options.preset,
                                      .runs = options.runs,
                                      .objects = options.objects,
                                      .seed = world.seed,
                                      .force = options.force,
                                      .threads = options.threads},
                                     progress);
              }};
}

bool began_to_simulate(const StudyOptions& options, const World& world, const experiments::StepRunner& runner) {
  const json known = runner.inputs_of("simulate" + world.suffix());
  return known.is_object() && known.contains("data") && known.at("data") == experiments::from_folder(world.data, options.out);
}

/// Simulates if there are no runs, or if this study began to simulate them.
/// @return  whether it did
bool simulate_runs(const StudyOptions& options, const World& world, experiments::StepRunner& runner) {
  if (began_to_simulate(options, world, runner) || simulated_files(world.data).is_null()) {
    runner.run(simulation_step(options, world));
    return true;
  }
  // All existing runs are used. Options that choose what to simulate must not seem to choose among them.
  if (!options.objects.empty() || options.runs) {
    throw Error(
        fmt::format("{}: holds runs already, and all of them are studied; expected no --objects or --runs, which choose what "
                    "to simulate, or another folder",
                    world.data.string()));
  }
  return false;
}

/// @throws Error  if there are none
std::vector<RunFolder> runs_to_study(const fs::path& data, PreparedWorld& prepared, const WarningCallback& warn) {
  const RunsBelow below = is_there(data) ? look_for_runs(data) : RunsBelow{};
  if (warn) std::for_each(below.misnamed.begin(), below.misnamed.end(), warn);
  prepared.errors = below.unreadable;
  if (below.runs.empty() && !prepared.errors.empty()) throw Error(prepared.errors.front());
  if (below.runs.empty())
    throw Error(data.string() + ": no runs; expected DATA/<object>/<run>, or no such folder to simulate them");
  return below.runs;
}

/// The hash of each run's labels as datasets know them, null if there are none that can be read; null if no run has labels.
json hashes_of_labels(const std::vector<RunFolder>& runs) {
  json hashes;
  bool any = false;
  for (const RunFolder& run : runs) {
    json& hash = hashes[run.name()];
    try {
      if (is_there(run.labels())) hash = labels::touches_sha256(labels::read_labels(run.labels()));
    } catch (const Error&) {
      // 'windows' names the run and the reason.
    }
    any = any || !hash.is_null();
  }
  return any ? hashes : json();
}

void label(const StudyOptions& options, const std::vector<RunFolder>& runs, experiments::StepRunner& runner,
           PreparedWorld& prepared) {
  json inputs;
  for (const RunFolder& run : runs) {
    inputs[run.name()] = {state_of_file(run.events()), state_of_file(run.robot()), state_of_file(run.video()),
                          state_of_file(run.video_times()), state_of_file(run.info())};
  }
  std::map<std::string, std::string> error_of;
  const World& world = prepared.world;
  runner.run({.name = "label" + world.suffix(),
              .command = experiments::command_of({"label", world.data.string(), "--no-pictures"}),
              .inputs = inputs,
              .outputs = [&runs] { return hashes_of_labels(runs); },
              .work =
                  [&](const ProgressCallback& progress) {
                    for (const labels::RunOutcome& outcome : labels::label_runs(runs, {.threads = options.threads}, progress)) {
                      if (!outcome.error.empty()) error_of[outcome.run.name()] = outcome.error;
                    }
                    if (error_of.size() == runs.size()) throw Error(error_of.begin()->second);
                  }});
  for (const RunFolder& run : runs) {
    const auto error = error_of.find(run.name());
    if (error != error_of.end()) {
      prepared.errors.push_back(error->second + "; " + run.name() + " is left out");
    } else if (!is_there(run.labels())) {
      prepared.errors.push_back(fmt::format("{}: has no labels and is left out; 'tactile label {}' shows why",
                                            run.folder.string(), shell_word(run.folder.string())));
    }
  }
}

/// Warns if the dataset of another study, or a user's own, will be replaced.
void warn_of_another_dataset(const fs::path& dataset, const windows::WindowsOptions& windows, const WarningCallback& warn) {
  if (!warn) return;
  const std::vector<std::string> differing = windows::settings_unlike_those_in(dataset, windows);
  if (differing.empty()) return;
  warn(fmt::format(
      "{} was made with other settings and is made again with {}; give each study a data folder of its own to keep both",
      dataset.string(), fmt::join(differing, ", ")));
}

void draw_samples(const StudyOptions& options, const std::vector<RunFolder>& runs, experiments::StepRunner& runner,
                  PreparedWorld& prepared, const WarningCallback& warn) {
  const World& world = prepared.world;
  windows::WindowsOptions windows;
  windows.sampling.seed = world.seed;
  windows.sampling.history = std::max(shortest_stored, options.histories.back());
  windows.include_flagged = options.include_flagged;
  windows.strict = options.strict;
  json events;
  for (const RunFolder& run : runs) events[run.name()] = state_of_file(run.events());
  std::vector<std::string> words{"windows", world.data.string()};
  if (world.seed != 1) words.insert(words.end(), {"--seed", std::to_string(world.seed)});
  if (windows.sampling.history != shortest_stored)
    words.insert(words.end(), {"--history-ms", experiments::ms_text(windows.sampling.history)});
  json inputs = {{"sampling", json_of_fields(windows.sampling)}, {"labels", hashes_of_labels(runs)}, {"events", events}};
  if (options.include_flagged) {
    words.emplace_back("--include-flagged");
    inputs["include_flagged"] = true;  // only if it is on, so that older steps without it are kept
  }
  runner.run({.name = "windows" + world.suffix(),
              .command = experiments::command_of(words),
              .inputs = inputs,
              .outputs =
                  [&] {
                    try {
                      return json(windows::Dataset(prepared.dataset).manifest_hash());
                    } catch (const Error&) {
                      return json();
                    }
                  },
              .work =
                  [&](const ProgressCallback& progress) {
                    warn_of_another_dataset(prepared.dataset, windows, warn);
                    const windows::DatasetSummary made =
                        windows::write_dataset(world.data, prepared.dataset, windows, options.threads, progress);
                    for (const std::string& error : made.errors) {
                      if (std::find(prepared.errors.begin(), prepared.errors.end(), error) == prepared.errors.end())
                        prepared.errors.push_back(error);
                    }
                  }});
}

void render_heatmaps(const StudyOptions& options, const PreparedWorld& prepared, experiments::StepRunner& runner) {
  const fs::path& file = prepared.dataset;
  const windows::Dataset dataset(file);
  std::vector<heatmaps::HeatmapOptions> renderings;
  std::vector<std::string> texts;
  for (const microseconds history : options.histories) {
    renderings.push_back({.history = history});
    texts.push_back(experiments::ms_text(history));
    heatmaps::check_renders(dataset, renderings.back());
  }
  const std::string histories = fmt::format("{}", fmt::join(texts, ","));
  runner.run({.name = "heatmaps" + prepared.world.suffix(),
              .command = experiments::command_of({"heatmaps", prepared.world.data.string(), "--th", histories}),
              .inputs = {{"manifest", dataset.manifest_hash()}, {"histories", histories}},
              .outputs =
                  [&] {
                    const windows::Dataset now(file);
                    json stored = json::array();
                    for (const heatmaps::HeatmapOptions& rendering : renderings) {
                      const auto found = now.find_heatmaps(heatmaps::stored_name(rendering));
                      if (!found) return json();
                      stored.push_back(found->name);
                    }
                    return stored;
                  },
              .work =
                  [&](const ProgressCallback& progress) {
                    heatmaps::store_heatmaps(windows::Dataset(file), renderings, options.threads, progress);
                  }});
}

}  // namespace

bool has_own_runs(const StudyOptions& options, const experiments::StepRunner& runner) {
  return is_there(options.data) && !find_runs(options.data).empty() && !began_to_simulate(options, {"", 0, options.data}, runner);
}

PreparedWorld prepare_world(const StudyOptions& options, const World& world, experiments::StepRunner& runner,
                            const WarningCallback& warn) {
  PreparedWorld prepared{.world = world, .dataset = world.data / "dataset.h5"};
  prepared.simulated = simulate_runs(options, world, runner);
  const std::vector<RunFolder> runs = runs_to_study(world.data, prepared, warn);
  label(options, runs, runner, prepared);
  draw_samples(options, runs, runner, prepared, warn);
  render_heatmaps(options, prepared, runner);
  return prepared;
}

}  // namespace tactile::study
