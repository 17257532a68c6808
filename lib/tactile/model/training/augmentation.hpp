#pragma once

#include <cstdint>
#include <span>

#include "tactile/core/random.hpp"
#include "tactile/events/event.hpp"
#include "tactile/model/definition/training_options.hpp"

namespace tactile::model {

/// Changes a heatmap at random, in place.
/// @param heatmap  [height, width] of `size`, row by row
/// @param random   used only for the selected augmentation
void augment(std::span<std::uint8_t> heatmap, events::SensorSize size, const Augmentation& augmentation, Random& random);

}  // namespace tactile::model
