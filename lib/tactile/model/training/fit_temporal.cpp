#include "tactile/model/training/fit_temporal.hpp"

#include "tactile/model/torch/torch_part.hpp"

namespace tactile::model {

FittedTemporal fit_temporal(std::span<const float> features, std::span<const Touch> truth, const TemporalOptions& options,
                            const TrainingOptions& training, const ProgressCallback& progress,
                            const std::function<void(const std::vector<EpochResult>& finished)>& on_epoch) {
  return torch_part().temporal_fit(features, truth, options, training, progress, on_epoch);
}

std::vector<std::array<float, touch_count>> temporal_logits_by_libtorch(std::span<const float> features,
                                                                        const TemporalOptions& options, const Weights& weights) {
  return torch_part().temporal_logits(features, options, weights);
}

}  // namespace tactile::model
