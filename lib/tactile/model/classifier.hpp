#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/engine/lenet_engine.hpp"
#include "tactile/events/event.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/engine_kind.hpp"
#include "tactile/model/logits.hpp"
#include "tactile/model/model_bundle.hpp"

namespace tactile {

/// A trained LeNet with the settings it was trained under.
class Classifier {
 public:
  /// Opens the model bundle `models/<name>/`.
  /// @param threads  0: as many as the machine has cores; the logits do not depend on it
  /// @param engine   what runs it; verdicts of both are the same but where `is_close` the logits
  /// @param options  of the fast engine
  /// @throws Error   if it is missing, incomplete or damaged: another format, weights that are not those of its hash, of the
  ///                 network's sizes, or finite; if the fast engine does not know its layers
  explicit Classifier(const std::filesystem::path& bundle, unsigned threads = 0, EngineKind engine = EngineKind::fast,
                      const EngineOptions& options = {});
  ~Classifier();
  Classifier(Classifier&&) noexcept;
  Classifier& operator=(Classifier&&) noexcept;

  const std::filesystem::path& bundle() const;
  const nlohmann::json& description() const;  ///< the bundle's model.json
  const ModelDescription& model() const;      ///< the same, read
  const HeatmapOptions& rendering() const;
  SensorSize input_size() const;
  EngineKind engine() const;

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
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
