#include "tactile/experiments/study/estimate_study.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/run_numbers.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/study/held_out_splits.hpp"
#include "tactile/experiments/training_speed.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/simulation/simulated_run.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/split.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;

constexpr double samples_of_simulated_run = 369;  // mean of 20
// Of dataset and models.
constexpr double bytes_of_sample = 5.9e3, bytes_of_heatmap = 2.5e3, bytes_of_model = 5.3e6;
const double tick_s = in_s(heatmaps::HeatmapOptions{}.tick);

/// The runs that a study has or would simulate.
struct StudiedRuns {
  std::map<std::string, std::size_t> of_object;
  double seconds = 0;  ///< length of all recordings
  bool are_there = false;
  std::size_t count = 0, labelled = 0;
  double samples = 0;    ///< of all
  std::string manifest;  ///< hash of the dataset's; empty if there is no dataset
  std::size_t stored_histories = 0;
  std::string samples_from;

  std::size_t objects() const { return of_object.size(); }
  bool has_dataset() const { return !manifest.empty(); }
};

StudiedRuns runs_to_simulate(const StudyOptions& options) {
  StudiedRuns runs;
  const simulation::SimulationPhysics& physics = simulation::default_physics();
  std::vector<std::string> objects = options.objects;
  if (objects.empty()) {
    for (const simulation::ObjectModel& object : physics.objects) objects.push_back(object.name);
  }
  const int of_each = options.runs.value_or(physics.preset(options.preset).runs);
  for (const std::string& object : objects) {
    for (int number = 1; number <= of_each; ++number) {
      const auto drawn = simulation::draw_run(physics, object, run_id_of(number), options.preset, options.seed);
      runs.seconds += drawn.plan.end_s;
      ++runs.of_object[object];
      ++runs.count;
    }
  }
  return runs;
}

StudiedRuns runs_in(const fs::path& data) {
  StudiedRuns runs;
  for (const RunFolder& run : find_runs(data)) {
    runs.seconds += tick_s * static_cast<double>(evaluation::expected_ticks(run.events(), {}));
    ++runs.of_object[run.object];
    ++runs.count;
    runs.labelled += is_there(run.labels()) ? 1 : 0;
  }
  runs.are_there = runs.count > 0;
  return runs;
}

StudiedRuns runs_of(const StudyOptions& options) {
  StudiedRuns runs = is_there(options.data) ? runs_in(options.data) : StudiedRuns{};
  if (!runs.are_there) runs = runs_to_simulate(options);
  runs.samples = samples_of_simulated_run * static_cast<double>(runs.count);
  runs.samples_from = fmt::format("{} samples a run, the mean of simulated runs", samples_of_simulated_run);
  const fs::path file = options.data / "dataset.h5";
  if (!is_there(file)) return runs;
  const windows::Dataset dataset(file);
  runs.manifest = dataset.manifest_hash();
  runs.samples = static_cast<double>(dataset.samples().size());
  runs.samples_from = file.string();
  for (const microseconds history : options.histories)
    runs.stored_histories += dataset.find_heatmaps(heatmaps::stored_name({.history = history})) ? 1 : 0;
  return runs;
}

/// Sets of objects that a study holds out of training, and how many objects are in each.
struct HeldOut {
  std::size_t sets = 0, objects = 0, splits = 0;
};

HeldOut held_out_of(const StudyOptions& options, const StudiedRuns& runs) {
  HeldOut held_out;
  for (const std::string& object : options.held_out.empty() ? windows::default_held_out() : options.held_out)
    held_out.objects += runs.of_object.contains(object) ? 1 : 0;
  if (held_out.objects >= runs.objects()) held_out.objects = 0;
  if (held_out.objects > 0) {
    std::vector<std::string> names;
    for (const auto& [object, count] : runs.of_object) names.push_back(object);
    held_out.splits = std::min(*options.splits, all_splits(names, held_out.objects).size());
    held_out.sets = 1;
  }
  if (options.hold_out_each && runs.objects() > 1) held_out.sets = runs.objects(), held_out.objects = 1;
  return held_out;
}

/// Steps of an earlier call that this one keeps, as far as their names and settings tell.
struct KeptSteps {
  std::size_t single = 0, without = 0, judgements = 0, evaluations = 0;
};

/// The split of a training that a study with these options also has; nothing for others, or if `inputs` cannot be read.
std::optional<windows::SplitKind> split_of_training(const StudyOptions& options, const nlohmann::json& inputs) {
  try {
    const auto settings = inputs.at("settings").get<model::ModelSettings>();
    const std::vector<microseconds>& histories = options.histories;
    const bool is_of_study = settings.training.epochs == *options.epochs &&
                             settings.training.seed - options.seed < *options.trainings &&
                             settings.training.engine == options.engine && settings.network == model::LeNetOptions{} &&
                             std::find(histories.begin(), histories.end(), settings.rendering.history) != histories.end();
    return is_of_study ? std::optional(settings.split.kind) : std::nullopt;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

/// @param manifest  hash of the dataset's
KeptSteps kept_steps(const StudyOptions& options, const std::string& manifest) {
  std::map<std::string, nlohmann::json> done;  // by name, with its inputs
  for (const nlohmann::json& step : experiments::step_records(options.out, "")) {
    if (!step.is_object() || step.value("done", nlohmann::json()) != true) continue;
    const nlohmann::json inputs = step.value("inputs", nlohmann::json());
    if (inputs.is_object() && inputs.value("manifest", nlohmann::json()) == manifest) done[step.value("name", "")] = inputs;
  }
  KeptSteps kept;
  for (const auto& [name, inputs] : done) {
    constexpr std::string_view training = "train-";
    if (name.starts_with("evaluate-")) ++kept.evaluations;
    if (!name.starts_with(training)) continue;
    const auto split = split_of_training(options, inputs);
    if (!split) continue;
    ++(*split == windows::SplitKind::unseen ? kept.without : kept.single);
    kept.judgements += done.contains("judge-" + name.substr(training.size())) ? 1 : 0;
  }
  return kept;
}

}  // namespace

experiments::Estimate estimate_study(const StudyOptions& requested) {
  const StudyOptions options = completed(requested);
  const StudiedRuns runs = runs_of(options);
  const HeldOut held_out = held_out_of(options, runs);
  const double usual = experiments::measured_training_speed();
  const double images_per_s =
      options.engine == model::EngineKind::fast ? usual : experiments::measured_training_speed(options.engine);
  const experiments::WorkCost cost = experiments::work_cost(usual);
  experiments::Estimate estimate{.parts = {}, .cores = options.threads, .images_per_s = images_per_s, .data = runs.samples_from};
  if (runs.count == 0) return estimate;
  const auto count = static_cast<double>(runs.count);
  const double run_s = runs.seconds / count, samples_of_run = runs.samples / count;
  if (!runs.are_there) {
    estimate.add({.what = "simulated runs", .count = runs.count}, cost.simulated_second * run_s,
                 experiments::bytes_of_second * run_s);
  }
  estimate.add({.what = "labelled runs", .count = runs.count, .exist = runs.labelled}, cost.labelled_second * run_s, 0);
  estimate.add({.what = "dataset", .count = 1, .exist = runs.has_dataset() ? 1U : 0U}, cost.second_of_windows * runs.seconds,
               bytes_of_sample * runs.samples);
  estimate.add({.what = "histories of heatmaps", .count = options.histories.size(), .exist = runs.stored_histories},
               cost.heatmap * runs.samples, bytes_of_heatmap * runs.samples);

  // Each training learns from one run of each object.
  const std::size_t single = options.histories.size() * *options.trainings;
  const std::size_t without = held_out.sets * *options.trainings + held_out.splits;
  const KeptSteps kept = runs.has_dataset() ? kept_steps(options, runs.manifest) : KeptSteps{};
  const auto training_s = [&](std::size_t objects) {
    return cost.training_start + static_cast<double>(objects) * samples_of_run * *options.epochs / images_per_s;
  };
  estimate.add({.what = "trainings", .count = single, .exist = std::min(kept.single, single), .one_thread = true},
               training_s(runs.objects()), bytes_of_model);
  estimate.add(
      {.what = "trainings without some objects", .count = without, .exist = std::min(kept.without, without), .one_thread = true},
      training_s(runs.objects() - held_out.objects), bytes_of_model);
  // A model is judged on the runs that it did not learn from, and reports on those that chose no history either.
  const auto share_without = [&](std::size_t runs_of_each) {
    return std::max(0.0, 1 - static_cast<double>(runs_of_each * runs.objects()) / count);
  };
  estimate.add({.what = "judgements of samples",
                .count = single + without,
                .exist = std::min(kept.judgements, single + without),
                .one_thread = true},
               cost.judged_sample * runs.samples * share_without(1), 0);
  const std::size_t choice = preset_settings(options.preset).choice_runs;
  const double ticks = runs.seconds / tick_s * (share_without(1) + share_without(1 + choice)) / 2;
  estimate.add({.what = "evaluations of all ticks", .count = 2, .exist = std::min<std::size_t>(kept.evaluations, 2)},
               *options.trainings * (cost.evaluation + cost.evaluated_tick * ticks), 0);
  return estimate;
}

}  // namespace tactile::study
