#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/characterise/scene.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/bundle/own_description.hpp"
#include "tactile/model/bundle/training_history.hpp"
#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/definition/model_settings.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::model {

/// A training run, identified by its recording: in another dataset, another run may have its name.
struct LearnedRun {
  std::string run;            ///< "fan/01"
  std::string events_sha256;  ///< of the recording's file
  std::string event_digest;   ///< `events::EventDigest`, which a compressed or converted copy shares; empty in older bundles
};

LearnedRun learned_run_of(const windows::DatasetRun& run);

/// Whether one of `runs` has the same file as `run`, or the same events in another file.
bool contains_recording(std::span<const LearnedRun> runs, const LearnedRun& run);

void to_json(nlohmann::json& json, const LearnedRun& run);  ///< {"run", "events_sha256", "event_digest"}
/// @param where  the file, for errors. @throws Error
LearnedRun learned_run_in(const nlohmann::json& json, const std::string& where);

/// The contents of `model.json`.
struct ModelDescription {
  ModelSettings settings;
  events::SensorSize input;             ///< as `input_of`: of a heatmap [cells], or of the sensor [px]
  std::string dataset;                  ///< file, as given
  std::string manifest_hash;            ///< of that dataset
  nlohmann::json manifest;              ///< settings of that dataset and hashes of its runs
  bool simulated = false;               ///< trained on simulated runs
  std::vector<std::string> train_runs;  ///< "fan/01"
  std::vector<std::string> test_runs;
  std::vector<LearnedRun> learned_from;              ///< the training runs, and those of its starting models
  std::uint64_t samples = 0;                         ///< training samples
  std::optional<characterise::SceneRanges> scene{};  ///< of the training runs' recordings; older bundles have none
  unsigned threads = 1;
  std::string trained_at;         ///< UTC, "2024-05-31T12:00:00.000000Z"
  std::string version, revision;  ///< of the software
  std::string weights_sha256;
  unsigned epoch = 0;                   ///< of these weights
  unsigned best_epoch = 0;              ///< with the smallest validation loss; training loss without a validation part
  std::optional<OwnDescription> own{};  ///< of kind own, which has no model.json
};

void to_json(nlohmann::json& json, const ModelDescription& description);
void from_json(const nlohmann::json& json, ModelDescription& description);  ///< @throws Error

/// Files of a model bundle: the folder `models/<name>/`. A network of one's own is its file instead; it has only results.
struct ModelBundle {
  std::filesystem::path folder;

  std::string name() const { return folder.filename().string(); }
  /// The folder of results: the bundle's, or "NAME.pt.results".
  std::filesystem::path results() const {
    return is_own_network(folder) ? std::filesystem::path(folder.string() + ".results") : folder;
  }
  std::filesystem::path description() const { return folder / "model.json"; }
  std::filesystem::path weights() const { return folder / "weights.safetensors"; }
  std::filesystem::path best_weights() const {
    return folder / "best.safetensors";
  }  ///< only if of another epoch than the weights
  std::filesystem::path last_weights() const {
    return folder / "last.safetensors";
  }  ///< only if of another epoch than the weights
  std::filesystem::path history() const { return folder / "history.csv"; }
  std::filesystem::path settings() const { return folder / "settings.json"; }  ///< of `tactile train`, for --config
  std::filesystem::path evaluation() const { return results() / "eval.json"; }
  std::filesystem::path unseen_evaluation() const { return results() / "eval-unseen.json"; }
};

/// The weights that a training writes to a bundle.
struct TrainedWeights {
  Weights weights;  ///< for inference
  Weights other;    ///< of the best epoch if the last epoch's are used, or vice versa; empty if they are the same
};

/// Writes a complete bundle, or nothing. An existing bundle is replaced with all its files, or refused. Sets `weights_sha256`,
/// `epoch` and `best_epoch`.
/// @param command_settings  the contents of `settings()`; null: there is no such file
/// @throws Error  if it cannot be written, or exists and must not be replaced
void write_bundle(const ModelBundle& bundle, ModelDescription description, const TrainedWeights& weights,
                  const TrainingSummary& summary, IfThere if_there = IfThere::replace,
                  const nlohmann::json& command_settings = {});

std::vector<std::string> names_of(const std::vector<LearnedRun>& runs);  ///< "fan/01"

/// Whether the model, or one of its starting models, learned from the recording of this run.
bool learned_from(const ModelDescription& model, const windows::DatasetRun& run);

/// The same of a recording outside a dataset. @throws Error  if it cannot be read
bool learned_from(const ModelDescription& model, const std::filesystem::path& recording);

/// The metadata of a weights file: classes, input shape and scale, layers, rendering, software, as JSON texts.
std::map<std::string, std::string> weights_metadata(const ModelDescription& description);

/// Of a network of one's own, what its description says.
/// @throws Error  if there is no such bundle, or its model.json is not of this format
ModelDescription read_description(const ModelBundle& bundle);

/// The bundle's weights. @throws Error  if their hash differs from `description`, or they have other sizes or are not finite
Weights read_bundle_weights(const ModelBundle& bundle, const ModelDescription& description);

/// The last trained bundle below `models` that `wanted` accepts; nothing if there is none. Folders without a readable model.json
/// are ignored.
std::optional<ModelBundle> newest_bundle(const std::filesystem::path& models,
                                         const std::function<bool(const ModelDescription&)>& wanted);

/// The bundle of a training in the folder `models`: the folder `name`, or the first of `name-2`, `name-3`, … that is free.
/// A name whose bundle cannot be read counts as free: the training reports what is wrong with it.
/// @param is_in_the_way  whether a bundle of such a name is to stay as it is
ModelBundle free_bundle(const std::filesystem::path& models, const std::string& name,
                        const std::function<bool(const ModelBundle&, const ModelDescription&)>& is_in_the_way);

}  // namespace tactile::model
