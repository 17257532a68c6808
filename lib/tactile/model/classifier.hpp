#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tactile/core/touch.hpp"
#include "tactile/events/event.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile {

using Logits = std::array<float, touch_count>;

/// A trained LeNet with the settings it was trained under.
class Classifier {
 public:
  /// Opens the model bundle `models/<name>/`. @throws Error if it is missing, incomplete or damaged
  explicit Classifier(const std::filesystem::path& bundle, unsigned threads = 0);
  ~Classifier();
  Classifier(Classifier&&) noexcept;
  Classifier& operator=(Classifier&&) noexcept;

  const std::filesystem::path& bundle() const;
  const nlohmann::json& description() const;  ///< the bundle's model.json
  const HeatmapOptions& rendering() const;
  SensorSize input_size() const;

  /// @param heatmaps  [n, height, width] of `input_size()`, one after the other
  /// @return n times the logits of none, press, slip
  std::vector<Logits> classify(std::span<const std::uint8_t> heatmaps) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The touch with the largest logit; the earlier one of equals.
Touch verdict_of(const Logits& logits);

}  // namespace tactile
