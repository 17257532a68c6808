#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "tactile/characterise/scene.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/bundle/gate.hpp"
#include "tactile/model/bundle/transitions.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::model {

/// What a bundle keeps of the recordings of its training runs, for `detect`.
struct SeenInRuns {
  Gate gate;
  /// Nothing if a recording is missing, and then the gate has no ratios; or if all are shorter than half a second.
  std::optional<characterise::SceneRanges> scene;
};

/// @param runs     by their index in the dataset
/// @param threads  each reads one recording, and holds one run's events of the dataset; 0: one per core
/// @throws Error  if no recording is missing, but one cannot be read, or differs from that which the dataset was made from
SeenInRuns seen_in(const windows::Dataset& dataset, std::span<const std::uint32_t> runs,
                   const heatmaps::HeatmapOptions& rendering, unsigned threads);

/// The transitions of the labels of these runs.
Transitions transitions_of(const windows::Dataset& dataset, std::span<const std::uint32_t> runs);

}  // namespace tactile::model
