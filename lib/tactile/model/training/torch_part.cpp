#include "tactile/model/torch/torch_part.hpp"

#include <cstddef>
#include <tuple>

#include "tactile/core/loaded_part.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/random.hpp"
#include "tactile/model/training/blas_threads.hpp"
#include "tactile/model/training/fully_connected.hpp"
#include "tactile/model/training/fused_convolutions.hpp"
#include "tactile/model/training/optimizer_steps.hpp"
#include "tactile/model/training/torch_version.hpp"
#include "tactile/model/training/training.hpp"

namespace tactile::model {
namespace {

constexpr void (*check_grid)(const StreamGrid&) = &check;
constexpr StreamBatch (StreamCrops::*batch_of)(std::uint64_t, unsigned) const = &StreamCrops::batch;

// The part calls functions of the program that loads it. These keep in each such program the files that it calls: at least one
// function of each.
[[gnu::used]] const std::tuple called_by_part(&parallel_for, &seed_for, &lenet_layers, &stream_parameters, &check_finite,
                                              &check_shapes, &heatmap_count, &verdict_of, &prepare_blas, &take_step,
                                              &moment_shapes, &FusedConvolutions::make_kept, &FullyConnected::forward, check_grid,
                                              batch_of);

}  // namespace

const TorchPart& torch_part() {
  static const auto& part =
      *static_cast<const TorchPart*>(load_part("tactile-torch.so", "tactile_torch_part", std::size_t{512} << 20));
  return part;
}

void load_libtorch() { torch_part(); }

}  // namespace tactile::model
