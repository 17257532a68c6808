#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/bundle/temperature.hpp"
#include "tactile/model/definition/engine_kind.hpp"
#include "tactile/model/inference/event_classifier.hpp"
#include "tactile/model/inference/heatmap_classifier.hpp"
#include "tactile/model/inference/lenet_engine.hpp"
#include "tactile/model/inference/logits.hpp"
#include "tactile/model/inference/own_network.hpp"
#include "tactile/model/inference/stream_network.hpp"

namespace tactile::model {

/// The logits of consecutive heatmaps. Must be thread-safe.
using ClassifyHeatmaps = std::function<std::vector<Logits>(std::span<const std::uint8_t> heatmaps, unsigned threads)>;

/// A network that reads heatmaps.
struct HeatmapNetwork {
  ClassifyHeatmaps classify;
  std::function<ClassifyHeatmap()> for_one_thread;  ///< makes a function that classifies single heatmaps
};

/// A trained model of any kind, with the settings of its training.
class Classifier {
 public:
  /// Opens the model bundle `models/<name>/` with the fast engine; `open_classifier` offers libtorch too.
  /// @param threads  0: one per core; the logits do not depend on it
  /// @throws Error   if it is missing, incomplete or damaged: another format, or weights with another hash, other sizes or values
  ///                 that are not finite; if the fast engine does not support its layers; if another kind gets another precision
  explicit Classifier(const std::filesystem::path& bundle, unsigned threads = 0, const EngineOptions& options = {});

  /// The same with another engine.
  /// @param make_network  makes a network that reads heatmaps from the bundle's description and weights
  /// @throws Error   also if the engine is libtorch, and the model reads no heatmaps
  Classifier(const std::filesystem::path& bundle, unsigned threads, EngineKind engine,
             const std::function<HeatmapNetwork(const ModelDescription&, const Weights&)>& make_network);

  /// A network that another program trained.
  /// @param file    NAME.pt or NAME.onnx, with its description beside it
  /// @param engine  what runs it
  /// @param open    opens it
  /// @throws Error  if the description cannot be read, or the network does not suit it
  Classifier(const std::filesystem::path& file, EngineKind engine,
             const std::function<OpenOwnNetwork(const NetworkPorts&)>& open);

  const std::filesystem::path& bundle() const { return bundle_.folder; }
  const nlohmann::json& description() const { return json_; }     ///< the bundle's model.json; of kind own, NAME.json
  const ModelDescription& model() const { return description_; }  ///< the same as a struct
  const heatmaps::HeatmapOptions& rendering() const { return description_.settings.rendering; }
  ModelKind kind() const { return description_.settings.kind; }
  events::SensorSize input_size() const { return description_.input; }  ///< as `input_of`
  EngineKind engine() const { return engine_; }
  const Temperature& temperature() const { return temperature_; }  ///< of its probabilities

  /// The model on the events of a stream, on one thread. Thread-safe.
  /// @param rendering  the model's own, except for tick and mask
  /// @throws Error  if the model was trained on another sensor or heatmap size, or does not suit the tick
  std::unique_ptr<EventClassifier> on_events(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering) const;

  /// Thread-safe.
  /// @param heatmaps  [n, height, width] of `input_size()`
  /// @return  n times the logits of none, press, slip
  /// @throws Error  if the size is not a whole number of heatmaps, or the model reads none
  std::vector<Logits> classify(std::span<const std::uint8_t> heatmaps) const;
  std::vector<Logits> classify(std::span<const std::uint8_t> heatmaps, unsigned threads) const;

  /// The verdicts for heatmaps, with the same parameters. Thread-safe.
  std::vector<Touch> verdicts(std::span<const std::uint8_t> heatmaps) const;
  std::vector<Touch> verdicts(std::span<const std::uint8_t> heatmaps, unsigned threads) const;

  /// The probabilities for heatmaps, with the same parameters. Thread-safe.
  std::vector<Probabilities> probabilities(std::span<const std::uint8_t> heatmaps) const;

 private:
  ModelBundle bundle_;
  nlohmann::json json_;
  ModelDescription description_;
  Temperature temperature_;
  unsigned threads_;
  EngineKind engine_;
  HeatmapNetwork network_;                       ///< of LeNet
  std::shared_ptr<const StreamNetwork> stream_;  ///< of kind stream
  OpenOwnNetwork open_own_;                      ///< of kind own
};

}  // namespace tactile::model
