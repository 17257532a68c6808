#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/model/bundle/training_history.hpp"
#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/inference/logits.hpp"
#include "tactile/model/training/stream_crops.hpp"

namespace tactile::model {

/// A network of kind `stream` that was trained.
struct FittedStream {
  Weights weights;
  std::vector<EpochResult> history;  ///< of each 100 steps
};

/// Trains a network of kind `stream` by libtorch, on one thread, on every tick of whole runs: the weighted cross-entropy of all
/// ticks of a batch, AdamW, a learning rate that rises to 0.006 in the first 3 of 10 steps and falls to 0 along half a cosine.
/// The counts enter by their 24 principal components, which are merged into the first layer's weights at the end. The same runs,
/// grid, options, seed and library give the same weights.
/// @param progress  called after each 10 steps; an exception from it ends the training
/// @param on_epoch  called after each 100 steps with all results so far; may be empty
/// @throws Error    as StreamCrops; if the loss is no longer finite; if libtorch cannot be loaded
FittedStream fit_stream(std::span<const StreamRun> runs, const StreamGrid& grid, const StreamOptions& options = {},
                        std::uint64_t seed = 1, const ProgressCallback& progress = {},
                        const std::function<void(const std::vector<EpochResult>& finished)>& on_epoch = {});

/// The logits of every tick by libtorch, from the start of a run. To compare with.
/// @param inputs  [tick, place, 145], as `stream_inputs` gives them
std::vector<Logits> stream_logits_by_libtorch(std::span<const float> inputs, const Weights& weights);

}  // namespace tactile::model
