#pragma once

#include <ATen/core/ivalue.h>  // clang 14 needs it before torch.h, which uses a vector of an incomplete type
#include <torch/torch.h>

#include <memory>
#include <vector>

#include "tactile/model/training/blas_threads.hpp"
#include "tactile/model/training/training.hpp"

namespace tactile::model {

/// Small networks train faster so, and the same everywhere.
inline void use_one_thread() {
  prepare_blas(1);
  if (at::get_num_threads() != 1) at::set_num_threads(1);
}

/// The values of a tensor, row by row.
inline std::vector<float> values_of(const torch::Tensor& tensor) {
  const torch::Tensor values = tensor.detach().to(torch::kFloat32).contiguous();
  const float* first = values.data_ptr<float>();
  return {first, first + values.numel()};
}

/// The optimizer of a training, with the settings that are ours: a weight decay of 0.01 (AdamW), a momentum of 0.9 (SGD).
inline std::unique_ptr<torch::optim::Optimizer> make_optimizer(OptimizerKind kind, const std::vector<torch::Tensor>& parameters,
                                                               double learning_rate) {
  if (kind == OptimizerKind::adamw)
    return std::make_unique<torch::optim::AdamW>(parameters, torch::optim::AdamWOptions(learning_rate).weight_decay(0.01));
  if (kind == OptimizerKind::sgd)
    return std::make_unique<torch::optim::SGD>(parameters, torch::optim::SGDOptions(learning_rate).momentum(0.9));
  return std::make_unique<torch::optim::Adam>(parameters, torch::optim::AdamOptions(learning_rate));
}

}  // namespace tactile::model
