#include "tactile/model/training/train_model.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <ctime>
#include <future>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/start_beside.hpp"
#include "tactile/core/utc_time.hpp"
#include "tactile/core/version.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/model/definition/model_network.hpp"
#include "tactile/model/training/fit_stream.hpp"
#include "tactile/model/training/scene_of_runs.hpp"
#include "tactile/model/training/stressed_heatmaps.hpp"
#include "tactile/model/training/torch_version.hpp"
#include "tactile/model/training/training_log.hpp"
#include "tactile/model/training/validation_cut.hpp"
#include "tactile/windows/dataset_split.hpp"

namespace tactile::model {
namespace {

/// The samples of the training runs, by their index in the dataset, with their classes.
struct CutSamples {
  std::vector<std::uint32_t> training, validation;
  std::vector<Touch> training_truth, validation_truth;
};

CutSamples cut_samples(const windows::Dataset& dataset, const ModelSettings& settings,
                       std::span<const std::uint32_t> train_runs) {
  const std::vector<std::uint32_t> indexes = samples_of_runs(dataset, train_runs);
  std::vector<windows::Sample> samples;
  samples.reserve(indexes.size());
  for (const std::uint32_t index : indexes) samples.push_back(dataset.samples()[index]);
  const ValidationCut cut = cut_in_time(samples, settings.training.validation_share, settings.rendering.history);
  CutSamples result;
  const auto take = [&](std::span<const std::uint32_t> places, std::vector<std::uint32_t>& into, std::vector<Touch>& truth) {
    for (const std::uint32_t place : places) {
      into.push_back(indexes[place]);
      truth.push_back(samples[place].touch);
    }
  };
  take(cut.training, result.training, result.training_truth);
  take(cut.validation, result.validation, result.validation_truth);
  if (settings.training.validation_share > 0 && result.validation.empty()) {
    throw Error(fmt::format("validation part of {}: contains none of the {} training samples; expected a larger part",
                            settings.training.validation_share, samples.size()));
  }
  return result;
}

}  // namespace

windows::Split split_of(const windows::Dataset& dataset, const windows::SplitOptions& options) {
  return windows::split_runs(dataset, options);
}

std::vector<std::uint32_t> learned_runs_of(const windows::Dataset& dataset, const ModelDescription& model) {
  std::vector<std::uint32_t> runs;
  for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
    if (learned_from(model, dataset.runs()[run])) runs.push_back(run);
  }
  return runs;
}

std::vector<std::uint32_t> test_runs_of(const windows::Dataset& dataset, const ModelDescription& model) {
  std::vector<std::uint32_t> runs;
  if (model.manifest_hash == dataset.manifest_hash()) {
    runs = split_of(dataset, model.settings.split).test_runs;
  } else {
    std::set<std::string> known_objects;  // of a model that is for objects it has not seen
    if (model.settings.split.kind == windows::SplitKind::unseen) {
      for (const std::string& run : names_of(model.learned_from)) known_objects.insert(run.substr(0, run.find('/')));
    }
    for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
      if (!known_objects.contains(dataset.runs()[run].object)) runs.push_back(run);
    }
  }
  std::erase_if(runs, [&](std::uint32_t run) { return learned_from(model, dataset.runs()[run]); });
  if (samples_of_runs(dataset, runs).empty()) {
    throw Error(fmt::format("{}: no run with samples remains for testing, the model learned from all others; expected one",
                            dataset.file().string()));
  }
  return runs;
}

std::vector<std::uint32_t> samples_of_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> run_indexes) {
  // Samples are sorted by run, and there may be many of both.
  std::vector<std::uint32_t> runs(run_indexes.begin(), run_indexes.end()), samples;
  std::sort(runs.begin(), runs.end());
  runs.erase(std::unique(runs.begin(), runs.end()), runs.end());
  const std::span<const windows::Sample> all = dataset.samples();
  for (const std::uint32_t run : runs) {
    const auto first = std::lower_bound(
        all.begin(), all.end(), run, [](const windows::Sample& sample, std::uint32_t index) { return sample.run_index < index; });
    for (auto sample = first; sample != all.end() && sample->run_index == run; ++sample)
      samples.push_back(static_cast<std::uint32_t>(sample - all.begin()));
  }
  return samples;
}

std::vector<std::uint8_t> sample_heatmaps(const windows::Dataset& dataset, const heatmaps::HeatmapOptions& options,
                                          std::span<const std::uint32_t> sample_indexes, unsigned threads,
                                          const ProgressCallback& progress) {
  const std::string name = heatmaps::stored_name(options);
  const auto stored = dataset.find_heatmaps(name);
  if (stored && stored->settings == nlohmann::json(options)) return dataset.read_heatmaps(name, sample_indexes);
  return heatmaps::render_samples(dataset, options, sample_indexes, threads, progress);
}

StartingPoint starting_point(const ModelBundle& from, const windows::Dataset& dataset, const ModelSettings& settings) {
  const ModelDescription model = read_description(from);
  read_bundle_weights(from, model);
  const std::string where = from.folder.string() + ": ";
  if (settings.kind != ModelKind::lenet || model.settings.kind != ModelKind::lenet)
    throw Error(where + "only LeNet starts from a model; expected two of kind lenet");
  if (model.settings.rendering != settings.rendering) {
    throw Error(fmt::format("{}learned from heatmaps with the settings {}; expected {}", where,
                            nlohmann::json(model.settings.rendering).dump(), nlohmann::json(settings.rendering).dump()));
  }
  if (model.settings.network != settings.network) {
    throw Error(fmt::format("{}has the network {}; expected {}", where, json_of_fields(model.settings.network).dump(),
                            json_of_fields(settings.network).dump()));
  }
  if (const events::SensorSize size = heatmaps::heatmap_size(dataset.sensor(), settings.rendering.factor); model.input != size) {
    throw Error(fmt::format("{}takes heatmaps of {} x {}; expected the {} x {} of {}", where, model.input.width,
                            model.input.height, size.width, size.height, dataset.file().string()));
  }
  if (settings.split.kind == windows::SplitKind::unseen) {
    for (const LearnedRun& learned : model.learned_from) {
      const std::string object = learned.run.substr(0, learned.run.find('/'));
      const auto& held_out = settings.split.held_out;
      if (std::find(held_out.begin(), held_out.end(), object) == held_out.end()) continue;
      throw Error(
          fmt::format("{}learned from {}, but {} is held out; expected a model of --split unseen with the same --held-out", where,
                      learned.run, object));
    }
  }
  return {from.name(), model.weights_sha256};
}

namespace {

/// Reads the weights to start from, if the settings name a model, and adds the runs that it learned from.
std::optional<Weights> starting_weights(const ModelSettings& settings, const std::filesystem::path& from,
                                        ModelDescription& description) {
  if (!settings.from) return std::nullopt;
  const ModelBundle start{from};
  const ModelDescription begun = read_description(start);
  std::optional<Weights> weights = read_bundle_weights(start, begun);
  for (const LearnedRun& learned : begun.learned_from) {
    if (!contains_recording(description.learned_from, learned)) description.learned_from.push_back(learned);
  }
  return weights;
}

/// Completes the description of a trained model.
void describe(ModelDescription& description, const windows::Dataset& dataset, const windows::Split& split,
              std::span<const std::uint32_t> test_runs) {
  description.dataset = dataset.file().string();
  description.manifest = dataset.settings();
  description.simulated = dataset.simulated();
  description.train_runs = names_of(dataset, split.train_runs);
  description.test_runs = names_of(dataset, test_runs);
  description.trained_at = now_utc();
  description.version = version();
  description.revision = revision();
}

/// What a training gives, of any kind of model.
struct Learned {
  TrainedWeights weights;
  TrainingSummary summary;
  unsigned threads = 1;
};

/// The state of a training that was interrupted, and the task that it belongs to.
struct Resumption {
  nlohmann::json task;
  unsigned threads = 1;
  std::optional<TrainingState> state;
};

Resumption resumption_of(const windows::Dataset& dataset, const ModelSettings& settings, const LeNetLayers& layers,
                         const ModelBundle& bundle, const TrainModelOptions& options, CheckpointFolder& kept) {
  Resumption resumed{.task = {{"settings", settings}, {"manifest_hash", dataset.manifest_hash()}},
                     .threads = threads_or_all(options.threads),
                     .state = std::nullopt};
  resumed.task["threads"] = resumed.threads;
  if (const auto begun = options.resume ? task_of_checkpoint(CheckpointFolder::beside(bundle.folder)) : std::nullopt) {
    const auto threads = member<unsigned>(*begun, "threads", bundle.folder.string());
    if (depends_on_threads(settings)) resumed.threads = threads;
    resumed.task["threads"] = threads;
    resumed.state = kept.load(resumed.task, layers, settings.training.optimizer);
  }
  if (!resumed.state) kept.clear();
  return resumed;
}

Learned learn_lenet(const windows::Dataset& dataset, const ModelSettings& settings, const CutSamples& samples,
                    const ModelBundle& bundle, const Weights* from, CheckpointFolder& kept, TrainingLog& log,
                    const TrainModelOptions& options, const ProgressCallback& progress) {
  const events::SensorSize size = input_of(settings, dataset.sensor());
  const Resumption resumed = resumption_of(dataset, settings, lenet_layers(size), bundle, options, kept);
  const unsigned threads = resumed.threads;
  const auto training = sample_heatmaps(dataset, settings.rendering, samples.training, threads, progress);
  const auto validation = sample_heatmaps(dataset, settings.rendering, samples.validation, threads, progress);
  if (options.begins) {
    const double part =
        static_cast<double>(resumed.state ? resumed.state->done : 0) / static_cast<double>(samples.training.size());
    options.begins(resumed.state ? resumed.state->epoch : 1, part);
  }
  log.begin(resumed.state ? resumed.state->history : std::vector<EpochResult>());
  // The log comes first: an epoch that it has and the state has not is done again, and then replaced there.
  const auto save = [&](const TrainingState& state) {
    log.see(state.history);
    kept.save(resumed.task, state);
  };
  StressedHeatmaps stressed(dataset, settings, samples.training, training, threads);
  const auto of_epoch = [&](unsigned epoch) { return stressed.of_epoch(epoch); };
  using OfEpoch = decltype(TrainingTask::heatmaps_of_epoch);
  const TrainingTask learning{.size = size,
                              .training = {training, samples.training_truth},
                              .heatmaps_of_epoch = settings.training.augmentation.stress.empty() ? OfEpoch() : OfEpoch(of_epoch),
                              .validation = {validation, samples.validation_truth},
                              .options = settings.training,
                              .network = settings.network,
                              .from = from,
                              .threads = threads};
  TrainedNetwork trained = train_lenet(learning, {.progress = progress,
                                                  .save = save,
                                                  .save_every = options.save_every,
                                                  .resumed = resumed.state ? &*resumed.state : nullptr});
  return {{trained.network.weights(), std::move(trained.other)}, trained.summary, threads};
}

/// A network of kind stream learns from every tick of whole runs, within minutes. Therefore no state is kept.
Learned learn_stream(const windows::Dataset& dataset, const ModelSettings& settings, std::span<const std::uint32_t> train_runs,
                     CheckpointFolder& kept, TrainingLog& log, const TrainModelOptions& options,
                     const ProgressCallback& progress) {
  kept.clear();
  log.begin({});
  const StreamGrid grid = grid_of_runs(dataset, train_runs, settings.rendering.mask);
  const std::vector<StreamRun> runs = stream_runs(dataset, train_runs, grid, settings.rendering, options.threads, progress);
  if (options.begins) options.begins(1, 0);
  const auto see = [&log](const std::vector<EpochResult>& history) { log.see(history); };
  FittedStream fitted = fit_stream(runs, grid, settings.stream, settings.training.seed, progress, see);
  TrainingSummary summary;
  summary.history = std::move(fitted.history);
  summary.best_epoch = summary.history.back().epoch;
  for (const StreamRun& run : runs) summary.samples += run.ticks;
  for (const EpochResult& epoch : summary.history) summary.seconds += epoch.seconds;
  return {{std::move(fitted.weights), {}}, summary, 1};
}

}  // namespace

TrainingSummary train_model(const windows::Dataset& dataset, const ModelSettings& settings, const ModelBundle& bundle,
                            const TrainModelOptions& options, const ProgressCallback& progress) {
  check(settings.training);
  const windows::Split split = split_of(dataset, settings.split);
  ModelDescription description;
  description.settings = settings;
  description.input = input_of(settings, dataset.sensor());
  parameters_of(settings, description.input);  // throws for a heatmap that is too small before any is rendered
  const CutSamples samples = cut_samples(dataset, settings, split.train_runs);
  for (const std::uint32_t run : split.train_runs) description.learned_from.push_back(learned_run_of(dataset.runs()[run]));
  const std::optional<Weights> from = starting_weights(settings, options.from, description);
  description.manifest_hash = dataset.manifest_hash();
  const std::vector<std::uint32_t> test_runs = test_runs_of(dataset, description);
  // Loading libtorch takes most of a second. Where memory is limited, it must not run short meanwhile.
  std::future<void> loading;
  if (!memory_is_limited()) loading = start_beside(options.threads, load_libtorch);
  description.scene = scene_of_runs(dataset, split.train_runs, settings.rendering.mask, options.threads);
  if (loading.valid()) loading.get();  // what follows may fork

  const std::filesystem::path beside = CheckpointFolder::beside(bundle.folder);
  CheckpointFolder kept(beside);
  TrainingLog log(beside / bundle.history().filename(), options.tensorboard);
  const Learned learned =
      settings.kind == ModelKind::stream
          ? learn_stream(dataset, settings, split.train_runs, kept, log, options, progress)
          : learn_lenet(dataset, settings, samples, bundle, from ? &*from : nullptr, kept, log, options, progress);
  description.samples = learned.summary.samples;
  description.threads = learned.threads;
  describe(description, dataset, split, test_runs);
  write_bundle(bundle, description, learned.weights, learned.summary, options.if_there, options.command_settings);
  kept.remove();
  return learned.summary;
}

}  // namespace tactile::model
