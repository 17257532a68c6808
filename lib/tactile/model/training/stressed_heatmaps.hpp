#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tactile/model/definition/model_settings.hpp"
#include "tactile/recipes/recipe.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::model {

/// What is done to a training run in an epoch: with the chance 1/2 nothing; else one of the recipes, each alike, with a severity
/// that is uniform between 0 and its own, rounded up where only whole ones are allowed. It depends on nothing else.
/// @param epoch  from 1
std::optional<recipes::Recipe> drawn_stress(std::span<const recipes::Recipe> recipes, std::uint64_t seed, unsigned epoch,
                                            std::string_view run);

/// The heatmaps of training samples under `Augmentation::stress`. The recipes change the events that the dataset stores, and the
/// renderer is the usual one. Nothing is kept from one epoch to the next.
class StressedHeatmaps {
 public:
  /// @param samples   into `dataset.samples()`, ascending
  /// @param heatmaps  of the samples without stress, as long as this object
  /// @param threads   > 0; the heatmaps do not depend on it
  StressedHeatmaps(const windows::Dataset& dataset, const ModelSettings& settings, std::span<const std::uint32_t> samples,
                   std::span<const std::uint8_t> heatmaps, unsigned threads);

  /// @param epoch    from 1
  /// @return         [samples, height, width], until the next call
  /// @throws Error   as `recipes::RecipeStream` and `heatmaps::render_events`
  std::span<const std::uint8_t> of_epoch(unsigned epoch);

 private:
  struct Run {
    std::uint32_t index = 0;
    std::vector<std::size_t> places;  ///< of its samples
  };
  void render(const Run& run, const recipes::Recipe& recipe);

  const windows::Dataset& dataset_;
  const ModelSettings& settings_;
  std::span<const std::uint32_t> samples_;
  std::span<const std::uint8_t> clean_;
  unsigned threads_;
  std::vector<Run> runs_;
  std::vector<std::uint8_t> stressed_;
};

}  // namespace tactile::model
