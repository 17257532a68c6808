#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/whole_file.hpp"
#include "tactile/model/bundle/gate.hpp"
#include "tactile/model/bundle/training_history.hpp"
#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/definition/model_settings.hpp"

namespace tactile {

/// A run that weights learned from, known by what was recorded: in another dataset its name may be another run's.
struct LearnedRun {
  std::string run;  ///< "fan/01"
  std::string events_sha256;

  friend bool operator==(const LearnedRun&, const LearnedRun&) = default;
};

/// What `model.json` says of a model.
struct ModelDescription {
  ModelSettings settings;
  SensorSize input;                     ///< of a heatmap [cells]
  std::string dataset;                  ///< file, as it was given
  std::string manifest_hash;            ///< of that dataset
  nlohmann::json manifest;              ///< that dataset's settings and the hashes of its runs
  bool simulated = false;               ///< learned from simulated runs
  std::vector<std::string> train_runs;  ///< "fan/01"
  std::vector<std::string> test_runs;
  std::vector<LearnedRun> learned_from;  ///< the training runs, and those of every model that it went on from
  std::uint64_t samples = 0;             ///< learned from
  std::optional<Gate> gate;              ///< calibrated on the training runs; bundles of earlier versions have none
  unsigned threads = 1;
  std::string trained_at;         ///< UTC, "2024-05-31T12:00:00.000000Z"
  std::string version, revision;  ///< of the software
  std::string weights_sha256;
  unsigned epoch = 0;       ///< whose weights these are
  unsigned best_epoch = 0;  ///< the one with the smallest loss, validation's where there is such a part
};

void to_json(nlohmann::json& json, const ModelDescription& description);
void from_json(const nlohmann::json& json, ModelDescription& description);  ///< @throws Error

/// Files of a model bundle: the folder `models/<name>/`.
struct ModelBundle {
  std::filesystem::path folder;

  std::string name() const { return folder.filename().string(); }
  std::filesystem::path description() const { return folder / "model.json"; }
  std::filesystem::path weights() const { return folder / "weights.safetensors"; }
  std::filesystem::path best_weights() const { return folder / "best.safetensors"; }  ///< where another epoch's than the weights
  std::filesystem::path last_weights() const { return folder / "last.safetensors"; }  ///< likewise
  std::filesystem::path history() const { return folder / "history.csv"; }
  std::filesystem::path evaluation() const { return folder / "eval.json"; }
  std::filesystem::path unseen_evaluation() const { return folder / "eval-unseen.json"; }
};

/// What a training gives to a bundle.
struct TrainedWeights {
  Weights weights;  ///< those to use
  Weights other;    ///< the best epoch's where the last's are used, or the other way round; empty where they are the same
};

/// Writes a bundle, whole or not at all; one that is there under its name is replaced, with all that lies in it, or refused. Sets
/// `weights_sha256`, `epoch` and `best_epoch`. @throws Error if it cannot be written, or is there and must not be replaced
void write_bundle(const ModelBundle& bundle, ModelDescription description, const TrainedWeights& weights,
                  const TrainingSummary& summary, IfThere if_there = IfThere::replace);

std::vector<std::string> names_of(const std::vector<LearnedRun>& runs);  ///< "fan/01"

/// Whether the model, or one that it went on from, learned from the run of this recording.
bool learned_from(const ModelDescription& model, const std::string& events_sha256);

/// What a weights file says of itself wherever it goes: classes, input shape and scale, layers, rendering, software; JSON texts.
std::map<std::string, std::string> weights_metadata(const ModelDescription& description);

/// @throws Error  if there is no such bundle, or its model.json is not of this format
ModelDescription read_description(const ModelBundle& bundle);

/// The bundle's weights. @throws Error  if they are not those that `description` names by hash, of the network's sizes, and
/// finite
Weights read_bundle_weights(const ModelBundle& bundle, const ModelDescription& description);

/// The least number of events in t_h that the network is to be asked about.
/// @throws Error  if the bundle was made without a gate
std::uint64_t gate_limit(const ModelBundle& bundle, const ModelDescription& description);

/// The bundle below `models` that was trained last of those that `wanted` takes; nothing if there is none. Folders that hold no
/// readable model.json are passed over.
std::optional<ModelBundle> newest_bundle(const std::filesystem::path& models,
                                         const std::function<bool(const ModelDescription&)>& wanted);

}  // namespace tactile
