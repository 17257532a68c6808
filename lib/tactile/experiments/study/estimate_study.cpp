#include "tactile/experiments/study/estimate_study.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/run_numbers.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/study/prepare_data.hpp"
#include "tactile/experiments/training_speed.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/simulation/simulated_run.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;

constexpr double samples_of_simulated_run = 369;  // mean of 20
// Of dataset and models.
constexpr double bytes_of_sample = 5.9e3, bytes_of_heatmap = 2.5e3, bytes_of_model = 5.3e6;
const double tick_s = in_s(heatmaps::HeatmapOptions{}.tick);

/// The runs that a study has or would simulate, in all of its worlds.
struct StudiedRuns {
  std::map<std::string, std::size_t> of_object;
  double seconds = 0;  ///< length of all recordings
  std::size_t there = 0, count = 0, labelled = 0;
  std::size_t datasets = 0, stored_histories = 0;
  double samples = 0;  ///< of all
  std::string samples_from;

  std::size_t objects() const { return of_object.size(); }
};

void add_runs_to_simulate(const StudyOptions& options, const World& world, StudiedRuns& runs) {
  const simulation::SimulationPhysics& physics = simulation::default_physics();
  std::vector<std::string> objects = options.objects;
  if (objects.empty()) {
    for (const simulation::ObjectModel& object : physics.objects) objects.push_back(object.name);
  }
  const int of_each = options.runs.value_or(physics.preset(options.preset).runs);
  for (const std::string& object : objects) {
    for (int number = 1; number <= of_each; ++number) {
      const auto drawn = simulation::draw_run(physics, object, run_id_of(number), options.preset, world.seed);
      runs.seconds += drawn.plan.end_s;
      ++runs.of_object[object];
      ++runs.count;
    }
  }
}

void add_runs(const StudyOptions& options, const World& world, StudiedRuns& runs) {
  const std::vector<RunFolder> found = is_there(world.data) ? find_runs(world.data) : std::vector<RunFolder>{};
  const std::size_t before = runs.count;
  for (const RunFolder& run : found) {
    runs.seconds += tick_s * static_cast<double>(evaluation::expected_ticks(run.events(), {}));
    ++runs.of_object[run.object];
    ++runs.count;
    ++runs.there;
    runs.labelled += is_there(run.labels()) ? 1 : 0;
  }
  if (found.empty()) add_runs_to_simulate(options, world, runs);
  const fs::path file = world.data / "dataset.h5";
  if (!is_there(file)) {
    runs.samples += samples_of_simulated_run * static_cast<double>(runs.count - before);
    return;
  }
  const windows::Dataset dataset(file);
  ++runs.datasets;
  runs.samples += static_cast<double>(dataset.samples().size());
  for (const microseconds history : options.histories)
    runs.stored_histories += dataset.find_heatmaps(heatmaps::stored_name({.history = history})) ? 1 : 0;
}

/// The steps of an earlier call whose names begin so and that are done.
std::size_t done_steps(const StudyOptions& options, std::string_view begin) {
  std::size_t done = 0;
  for (const nlohmann::json& step : experiments::step_records(options.out, begin))
    done += step.is_object() && step.value("done", nlohmann::json()) == true ? 1 : 0;
  return done;
}

}  // namespace

experiments::Estimate estimate_study(const StudyOptions& requested) {
  const experiments::StepRunner known({.folder = requested.out, .program = requested.program});
  const StudyOptions options = completed(requested, has_own_runs(requested, known));
  const std::vector<World> worlds = worlds_of(options);
  StudiedRuns runs;
  for (const World& world : worlds) add_runs(options, world, runs);
  const double usual = experiments::measured_training_speed();
  const double images_per_s =
      options.engine == model::EngineKind::fast ? usual : experiments::measured_training_speed(options.engine);
  const experiments::WorkCost cost = experiments::work_cost(usual);
  const bool all_known = runs.datasets == worlds.size();
  experiments::Estimate estimate{
      .parts = {},
      .cores = options.threads,
      .images_per_s = images_per_s,
      .data = all_known ? "the datasets" : fmt::format("{} samples a run, the mean of simulated runs", samples_of_simulated_run)};
  if (runs.count == 0) return estimate;
  const auto count = static_cast<double>(runs.count), of_worlds = static_cast<double>(worlds.size());
  const double run_s = runs.seconds / count, samples_of_run = runs.samples / count;
  if (runs.there < runs.count) {
    estimate.add({.what = "simulated runs", .count = runs.count, .exist = runs.there}, cost.simulated_second * run_s,
                 experiments::bytes_of_second * run_s);
  }
  estimate.add({.what = "labelled runs", .count = runs.count, .exist = runs.labelled}, cost.labelled_second * run_s, 0);
  estimate.add({.what = "datasets", .count = worlds.size(), .exist = runs.datasets},
               cost.second_of_windows * runs.seconds / of_worlds, bytes_of_sample * runs.samples / of_worlds);
  estimate.add(
      {.what = "histories of heatmaps", .count = worlds.size() * options.histories.size(), .exist = runs.stored_histories},
      cost.heatmap * runs.samples / of_worlds, bytes_of_heatmap * runs.samples / of_worlds);

  // Each training learns from one run of each object, and half of the objects are held out of others.
  const std::size_t each = worlds.size() * *options.trainings;
  const std::size_t lenets = each * (options.histories.size() + 1), streams = each * 2;
  const auto objects = static_cast<double>(runs.objects());
  estimate.add({.what = "trainings of LeNet",
                .count = lenets,
                .exist = std::min(lenets, done_steps(options, "train-th")),
                .one_thread = true},
               cost.training_start + objects * samples_of_run * *options.epochs / images_per_s, bytes_of_model);
  estimate.add({.what = "trainings of streams",
                .count = streams,
                .exist = std::min(streams, done_steps(options, "train-stream")),
                .one_thread = true},
               cost.stream_step * *options.steps, bytes_of_model / 10);
  // A model is judged on the runs that it did not learn from: two of LeNet and two streams at every tick, the rest on samples.
  const double left = std::max(0.0, 1 - objects * of_worlds / count);
  const std::size_t of_samples = each * (options.histories.size() - 1), whole = each * 4;
  const std::size_t judged = done_steps(options, "judge-");
  estimate.add({.what = "judgements of samples",
                .count = of_samples,
                .exist = judged >= of_samples + whole ? of_samples : 0,
                .one_thread = true},
               cost.judged_sample * runs.samples / of_worlds * left, 0);
  estimate.add(
      {.what = "judgements of whole runs", .count = whole, .exist = judged >= of_samples + whole ? whole : 0, .one_thread = true},
      cost.evaluated_tick * runs.seconds / of_worlds / tick_s * left, 0);
  return estimate;
}

}  // namespace tactile::study
