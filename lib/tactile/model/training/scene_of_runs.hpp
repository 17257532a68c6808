#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "tactile/characterise/scene.hpp"
#include "tactile/events/pixel_mask.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::model {

/// The scenes of the recordings of training runs, which a bundle keeps for `detect`. Nothing if a recording is missing, or if all
/// are shorter than half a second.
/// @param runs     by their index in the dataset
/// @param threads  each reads one recording; 0: one per core
/// @throws Error  if no recording is missing, but one cannot be read, or differs from that which the dataset was made from
std::optional<characterise::SceneRanges> scene_of_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> runs,
                                                       const events::MaskPixels& mask, unsigned threads);

}  // namespace tactile::model
