#pragma once

#include <span>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/model/bundle/temperature.hpp"
#include "tactile/model/inference/logits.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::model {

/// The mean of -log p of the true class, at a temperature [nats].
double loss_at(std::span<const Logits> logits, std::span<const Touch> truth, double temperature);

/// The temperature with the smallest loss, between 1/20 and 20. The loss has one minimum over 1 / temperature.
/// @param logits  at least one  @param truth  one for each
double fitted_temperature(std::span<const Logits> logits, std::span<const Touch> truth);

/// Fits a temperature on the balanced samples of runs that the model did not learn from, and stores it in the bundle. The runs
/// of held-out objects are left out.
/// @param runs  ids within each object, "02"
/// @throws Error  if no such run has samples, or none is left to test the model
Temperature calibrate_model(const windows::Dataset& dataset, const ModelBundle& bundle, std::span<const std::string> runs,
                            unsigned threads);

}  // namespace tactile::model
