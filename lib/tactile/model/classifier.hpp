#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/logits.hpp"
#include "tactile/model/model_bundle.hpp"

namespace tactile {

/// A trained LeNet with the settings it was trained under.
class Classifier {
 public:
  /// Opens the model bundle `models/<name>/`.
  /// @param threads  0: as many as the machine has cores; the logits do not depend on it
  /// @throws Error  if it is missing, incomplete or damaged: another format, weights that are not those of its hash, of the
  /// network's
  ///                sizes, or finite
  explicit Classifier(const std::filesystem::path& bundle, unsigned threads = 0);
  ~Classifier();
  Classifier(Classifier&&) noexcept;
  Classifier& operator=(Classifier&&) noexcept;

  const std::filesystem::path& bundle() const;
  const nlohmann::json& description() const;  ///< the bundle's model.json
  const ModelDescription& model() const;      ///< the same, read
  const HeatmapOptions& rendering() const;
  SensorSize input_size() const;

  /// @param heatmaps  [n, height, width] of `input_size()`, one after the other
  /// @return n times the logits of none, press, slip
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
