#pragma once

#include "tactile/model/definition/engine_kind.hpp"

namespace tactile::experiments {

/// How many heatmaps one thread of this machine trains LeNet on in a second of processor time. Measured in about a second, on
/// heatmaps of noise of 128 x 96 cells, in batches of 32.
/// @throws Error  as `model::train_lenet`
double measured_training_speed(model::EngineKind engine = model::EngineKind::fast);

}  // namespace tactile::experiments
