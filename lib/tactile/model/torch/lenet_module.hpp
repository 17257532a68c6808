#pragma once

#include <ATen/core/ivalue.h>  // clang 14 needs it before torch.h, which uses a vector of an incomplete type
#include <torch/torch.h>

#include "tactile/core/touch.hpp"
#include "tactile/model/definition/lenet_layers.hpp"

namespace tactile::model {

/// The largest value of each 2 x 2 block and its gradient, bit-identical to torch::max_pool2d(x, 2), which processes one value at
/// a time and took a quarter of the run time.
class LargestOfBlocks : public torch::autograd::Function<LargestOfBlocks> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& input) {
    const torch::Tensor x = input.contiguous();
    torch::Tensor largest = torch::empty({x.size(0), x.size(1), x.size(2) / 2, x.size(3) / 2});
    const Blocks blocks(x);
    for (std::int64_t row = 0; row < blocks.rows; ++row) {
      const float* upper = x.data_ptr<float>() + blocks.offset(row);
      const float* lower = upper + blocks.stride;
      float* out = largest.data_ptr<float>() + row * blocks.width;
      for (std::int64_t i = 0; i < blocks.width; ++i) {
        float best = upper[2 * i];
        best = takes(best, upper[2 * i + 1]) ? upper[2 * i + 1] : best;
        best = takes(best, lower[2 * i]) ? lower[2 * i] : best;
        out[i] = takes(best, lower[2 * i + 1]) ? lower[2 * i + 1] : best;
      }
    }
    context->save_for_backward({x});
    return largest;
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 const torch::autograd::variable_list& gradients) {
    const torch::Tensor x = context->get_saved_variables()[0], gradient = gradients[0].contiguous();
    const Blocks blocks(x);
    const bool leaves_some = x.size(2) % 2 != 0 || x.size(3) % 2 != 0;  // a row or column outside all blocks
    const torch::Tensor result = leaves_some ? torch::zeros_like(x) : torch::empty_like(x);
    for (std::int64_t row = 0; row < blocks.rows; ++row) {
      const float* upper = x.data_ptr<float>() + blocks.offset(row);
      const float* lower = upper + blocks.stride;
      const float* in = gradient.data_ptr<float>() + row * blocks.width;
      float* upper_out = result.data_ptr<float>() + blocks.offset(row);
      float* lower_out = upper_out + blocks.stride;
      for (std::int64_t i = 0; i < blocks.width; ++i) {
        const float a = upper[2 * i], b = upper[2 * i + 1], c = lower[2 * i], d = lower[2 * i + 1], gradient_of_block = in[i];
        const bool takes_b = takes(a, b);
        const float of_two = takes_b ? b : a;
        const bool takes_c = takes(of_two, c);
        const bool takes_d = takes(takes_c ? c : of_two, d);
        const float above = takes_d || takes_c ? 0.0F : gradient_of_block, below = takes_d ? 0.0F : gradient_of_block;
        upper_out[2 * i] = takes_b ? 0.0F : above;
        upper_out[2 * i + 1] = takes_b ? above : 0.0F;
        lower_out[2 * i] = takes_c ? below : 0.0F;
        lower_out[2 * i + 1] = takes_d ? gradient_of_block : 0.0F;
      }
    }
    return {result};
  }

 private:
  /// Whether `value` replaces `best` in a block. NaN stays, so that it is detected in the output.
  static bool takes(float best, float value) {
    return static_cast<bool>(static_cast<int>(value > best) | static_cast<int>(value != value));
  }

  /// Rows of blocks in all pictures and channels.
  struct Blocks {
    explicit Blocks(const torch::Tensor& x)
        : height(x.size(2) / 2), width(x.size(3) / 2), stride(x.size(3)), channel(x.size(2) * x.size(3)) {
      rows = x.size(0) * x.size(1) * height;
    }
    std::int64_t offset(std::int64_t row) const { return row / height * channel + row % height * 2 * stride; }

    std::int64_t height, width, stride, channel, rows = 0;
  };
};

/// The layers in libtorch.
struct LeNetModule : torch::nn::Module {
  LeNetModule(const LeNetLayers& layers, const LeNetOptions& chosen)
      : options(chosen),
        conv1(register_module("conv1", convolution(1, layers.first_channels))),
        conv2(register_module("conv2", convolution(layers.first_channels, layers.second_channels))),
        fc1(register_module("fc1", linear(layers.flat, layers.first_hidden))),
        fc2(register_module("fc2", linear(layers.first_hidden, layers.second_hidden))),
        fc3(register_module("fc3", linear(layers.second_hidden, touch_count))) {}

  static torch::nn::Conv2d convolution(std::size_t in, std::size_t out) {
    return torch::nn::Conv2d(torch::nn::Conv2dOptions(static_cast<std::int64_t>(in), static_cast<std::int64_t>(out), 5));
  }
  static torch::nn::Linear linear(std::size_t in, std::size_t out) {
    return torch::nn::Linear(static_cast<std::int64_t>(in), static_cast<std::int64_t>(out));
  }

  torch::Tensor activated(const torch::Tensor& x) const {
    return options.activation == Activation::relu   ? torch::relu(x)
           : options.activation == Activation::tanh ? torch::tanh(x)
                                                    : torch::sigmoid(x);
  }

  torch::Tensor pooled(const torch::Tensor& x) const {
    if (options.pooling == Pooling::average) return torch::avg_pool2d(x, 2);
    return x.scalar_type() == torch::kFloat32 ? LargestOfBlocks::apply(x) : torch::max_pool2d(x, 2);
  }

  /// An activation is monotonic, so it may be applied after max-pooling, to a quarter of the values.
  torch::Tensor activated_and_pooled(const torch::Tensor& x) const {
    return options.pooling == Pooling::average ? pooled(activated(x)) : activated(pooled(x));
  }

  torch::Tensor convolved(const torch::Tensor& x) {
    return activated_and_pooled(conv2->forward(activated_and_pooled(conv1->forward(x)))).flatten(1);
  }

  torch::Tensor connected(const torch::Tensor& x) { return connected_after_first(fc1->forward(x)); }

  /// After the first fully connected layer, which has almost all weights.
  torch::Tensor connected_after_first(const torch::Tensor& x) { return fc3->forward(activated(fc2->forward(activated(x)))); }

  torch::Tensor forward(const torch::Tensor& x) { return connected(convolved(x)); }

  LeNetOptions options;

  torch::nn::Conv2d conv1, conv2;
  torch::nn::Linear fc1, fc2, fc3;
};

}  // namespace tactile::model
