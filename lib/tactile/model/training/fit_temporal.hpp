#pragma once

#include <functional>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/model/bundle/training_history.hpp"
#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/definition/temporal_options.hpp"
#include "tactile/model/definition/training_options.hpp"

namespace tactile::model {

/// A temporal convolution that was trained.
struct FittedTemporal {
  Weights weights;
  std::vector<EpochResult> history;
};

/// Trains a temporal convolution by libtorch, on one thread: the cross-entropy, libtorch's default initialisation, the features
/// standardised over the samples. The same input, options and library give the same weights.
/// @param features  [truth.size(), 16, 12] of `features::StepFeatures`, finite
/// @param training  seed, epochs, batch, learning rate, schedule, optimizer and class weights are used
/// @param progress  called after each epoch; an exception from it ends the training
/// @param on_epoch  called after each epoch with all epochs so far; may be empty
/// @throws Error    if there is no sample or not as many features for each, if an option is out of its range, if the loss is no
///                  longer finite, or if libtorch cannot be loaded
FittedTemporal fit_temporal(std::span<const float> features, std::span<const Touch> truth, const TemporalOptions& options = {},
                            const TrainingOptions& training = {}, const ProgressCallback& progress = {},
                            const std::function<void(const std::vector<EpochResult>& finished)>& on_epoch = {});

/// The logits of the same network by libtorch, with dilated convolutions over all steps. To compare with.
/// @param features  [n, 16, 12]
std::vector<std::array<float, touch_count>> temporal_logits_by_libtorch(std::span<const float> features,
                                                                        const TemporalOptions& options, const Weights& weights);

}  // namespace tactile::model
