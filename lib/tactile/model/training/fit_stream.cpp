#include "tactile/model/training/fit_stream.hpp"

#include "tactile/model/torch/torch_part.hpp"

namespace tactile::model {

FittedStream fit_stream(std::span<const StreamRun> runs, const StreamGrid& grid, const StreamOptions& options, std::uint64_t seed,
                        const ProgressCallback& progress,
                        const std::function<void(const std::vector<EpochResult>& finished)>& on_epoch) {
  check_fields(options, "training of kind stream");
  return torch_part().stream_fit(runs, grid, options, seed, progress, on_epoch);
}

std::vector<Logits> stream_logits_by_libtorch(std::span<const float> inputs, const Weights& weights) {
  return torch_part().stream_logits(inputs, weights);
}

}  // namespace tactile::model
