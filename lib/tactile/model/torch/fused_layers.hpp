#pragma once

#include <ATen/core/ivalue.h>  // clang 14 needs it before torch.h, which uses a vector of an incomplete type
#include <torch/torch.h>

#include <algorithm>
#include <span>
#include <vector>

#include "tactile/core/parallel.hpp"
#include "tactile/model/training/fully_connected.hpp"
#include "tactile/model/training/fused_convolutions.hpp"

namespace tactile::model {

/// A batch in the fused layers, forward and backward, with memory that later batches reuse.
class FusedBatch {
 public:
  FusedBatch(const LeNetLayers& layers, unsigned threads)
      : layers_(layers),
        cells_(static_cast<std::size_t>(layers.input.width) * static_cast<std::size_t>(layers.input.height)),
        passes_(layers),
        workspaces_(threads, passes_.make_workspace()) {}

  unsigned threads() const { return static_cast<unsigned>(workspaces_.size()); }

  /// Sets the batch of the next pass, which it must outlive.
  void set_heatmaps(std::span<const std::uint8_t> heatmaps) { heatmaps_ = heatmaps; }

  torch::Tensor forward(const ConvolutionValues<const float>& weights) {
    passes_.set(weights);
    while (kept_.size() < count()) kept_.push_back(passes_.make_kept());
    torch::Tensor flat = torch::empty({static_cast<std::int64_t>(count()), static_cast<std::int64_t>(layers_.flat)});
    const std::span<float> values(flat.data_ptr<float>(), count() * layers_.flat);
    for_slices([&](std::size_t, std::size_t i, FusedConvolutions::Workspace& workspace) {
      passes_.forward(heatmap(i), values.subspan(i * layers_.flat, layers_.flat), kept_[i], workspace);
    });
    return flat;
  }

  void backward(const torch::Tensor& gradient, const ConvolutionValues<float>& into) {
    const std::span<const float> values(gradient.data_ptr<float>(), count() * layers_.flat);
    sums_.resize(std::max(sums_.size(), slices()));
    for (auto& sum : sums_) sum.clear();
    for_slices([&](std::size_t slice, std::size_t i, FusedConvolutions::Workspace& workspace) {
      passes_.backward(heatmap(i), kept_[i], values.subspan(i * layers_.flat, layers_.flat), sums_[slice], workspace);
    });
    for (std::size_t slice = 1; slice < slices(); ++slice) sums_[0].add(sums_[slice]);
    sums_[0].write(into);
  }

 private:
  static constexpr std::size_t slice_size = 2;  ///< heatmaps per partial sum of gradients, independent of the threads

  std::size_t count() const { return heatmaps_.size() / cells_; }
  std::size_t slices() const { return (count() + slice_size - 1) / slice_size; }
  std::span<const std::uint8_t> heatmap(std::size_t i) const { return heatmaps_.subspan(i * cells_, cells_); }

  /// Each slice runs on any free thread; the result does not depend on it.
  template <class Work>
  void for_slices(const Work& work) {
    parallel_for_with(std::span(workspaces_), slices(), [&](std::size_t slice, FusedConvolutions::Workspace& workspace) {
      for (std::size_t i = slice * slice_size; i < std::min(count(), (slice + 1) * slice_size); ++i) work(slice, i, workspace);
    });
  }

  LeNetLayers layers_;
  std::size_t cells_;
  FusedConvolutions passes_;
  std::span<const std::uint8_t> heatmaps_;
  std::vector<FusedConvolutions::Kept> kept_;             ///< of each heatmap
  std::vector<FusedConvolutions::Workspace> workspaces_;  ///< of each thread
  std::vector<FusedConvolutions::Gradients> sums_;        ///< of each slice
};

/// The convolution layers of a batch as a libtorch function.
class FusedLayers : public torch::autograd::Function<FusedLayers> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& first_weight,
                               const torch::Tensor& first_bias, const torch::Tensor& second_weight,
                               const torch::Tensor& second_bias, FusedBatch* batch) {
    context->saved_data["batch"] = static_cast<std::int64_t>(reinterpret_cast<std::intptr_t>(batch));
    return batch->forward({first_weight.data_ptr<float>(), first_bias.data_ptr<float>(), second_weight.data_ptr<float>(),
                           second_bias.data_ptr<float>()});
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 const torch::autograd::variable_list& gradients) {
    // The context keeps numbers and tensors alone.
    // NOLINTNEXTLINE(performance-no-int-to-ptr)
    auto* batch = reinterpret_cast<FusedBatch*>(static_cast<std::intptr_t>(context->saved_data["batch"].toInt()));
    const torch::Tensor first_weight = torch::empty({6, 1, 5, 5}), first_bias = torch::empty({6});
    const torch::Tensor second_weight = torch::empty({16, 6, 5, 5}), second_bias = torch::empty({16});
    batch->backward(gradients[0].contiguous(), {first_weight.data_ptr<float>(), first_bias.data_ptr<float>(),
                                                second_weight.data_ptr<float>(), second_bias.data_ptr<float>()});
    return {first_weight, first_bias, second_weight, second_bias, torch::Tensor()};
  }
};

/// A fully connected layer as a libtorch function.
class FusedLinear : public torch::autograd::Function<FusedLinear> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& input, const torch::Tensor& weight,
                               const torch::Tensor& bias, std::int64_t threads) {
    TORCH_CHECK(input.size(1) == weight.size(1) && bias.size(0) == weight.size(0));
    context->save_for_backward({input, weight});
    context->saved_data["threads"] = threads;
    torch::Tensor output = torch::empty({input.size(0), weight.size(0)});
    layer_of(weight).forward(values_of(input), values_of(weight), values_of(bias), values_in(output),
                             static_cast<unsigned>(threads));
    return output;
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 const torch::autograd::variable_list& gradients) {
    const torch::Tensor input = context->get_saved_variables()[0], weight = context->get_saved_variables()[1];
    const torch::Tensor gradient = gradients[0].contiguous();
    torch::Tensor of_input = torch::empty_like(input), of_weight = torch::empty_like(weight);
    layer_of(weight).backward(values_of(input), values_of(weight), values_of(gradient), values_in(of_input), values_in(of_weight),
                              static_cast<unsigned>(context->saved_data["threads"].toInt()));
    return {of_input, of_weight, gradient.sum(0), torch::Tensor()};
  }

 private:
  static FullyConnected layer_of(const torch::Tensor& weight) {
    return {static_cast<std::size_t>(weight.size(1)), static_cast<std::size_t>(weight.size(0))};
  }
  static std::span<const float> values_of(const torch::Tensor& tensor) {
    return {tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel())};
  }
  static std::span<float> values_in(torch::Tensor& tensor) {
    return {tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel())};
  }
};

}  // namespace tactile::model
