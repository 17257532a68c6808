#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/engine_kind.hpp"
#include "tactile/model/inference/lenet_engine.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile {

/// The logits of heatmaps that lie one after the other. May be called from several threads at once.
using ClassifyHeatmaps = std::function<std::vector<Logits>(std::span<const std::uint8_t> heatmaps, unsigned threads)>;

/// A trained LeNet with the settings it was trained under.
class Classifier {
 public:
  /// Opens the model bundle `models/<name>/` with the fast engine; `open_classifier` offers libtorch too.
  /// @param threads  0: as many as the machine has cores; the logits do not depend on it
  /// @throws Error   if it is missing, incomplete or damaged: another format, weights that are not those of its hash, of the
  ///                 network's sizes, or finite; if the fast engine does not know its layers
  explicit Classifier(const std::filesystem::path& bundle, unsigned threads = 0, const EngineOptions& options = {});

  /// The same with another engine.
  /// @param make_network  makes it of the bundle's description and weights
  Classifier(const std::filesystem::path& bundle, unsigned threads, EngineKind engine,
             const std::function<ClassifyHeatmaps(const ModelDescription&, const Weights&)>& make_network);

  const std::filesystem::path& bundle() const { return bundle_.folder; }
  const nlohmann::json& description() const { return json_; }     ///< the bundle's model.json
  const ModelDescription& model() const { return description_; }  ///< the same, read
  const HeatmapOptions& rendering() const { return description_.settings.rendering; }
  SensorSize input_size() const { return description_.input; }
  EngineKind engine() const { return engine_; }

  /// @param heatmaps  [n, height, width] of `input_size()`, one after the other
  /// @return n times the logits of none, press, slip. May be called from several threads at once
  /// @throws Error  if the heatmaps are no whole number of this network's input
  std::vector<Logits> classify(std::span<const std::uint8_t> heatmaps) const;
  std::vector<Logits> classify(std::span<const std::uint8_t> heatmaps, unsigned threads) const;

  /// The verdicts of the same. May be called from several threads at once.
  std::vector<Touch> verdicts(std::span<const std::uint8_t> heatmaps) const;
  std::vector<Touch> verdicts(std::span<const std::uint8_t> heatmaps, unsigned threads) const;

  /// The probabilities of the same. May be called from several threads at once.
  std::vector<Probabilities> probabilities(std::span<const std::uint8_t> heatmaps) const;

 private:
  ModelBundle bundle_;
  nlohmann::json json_;
  ModelDescription description_;
  unsigned threads_;
  EngineKind engine_;
  ClassifyHeatmaps network_;
};

}  // namespace tactile
