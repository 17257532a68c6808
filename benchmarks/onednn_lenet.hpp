#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/definition/lenet_layers.hpp"

#ifdef TACTILE_HAS_ONEDNN
#include <dnnl.hpp>

namespace tactile::bench {

/// LeNet of primitives of oneDNN, for one heatmap at a time. The library chooses the layouts; ReLU is fused into convolutions and
/// fully connected layers, as its manual recommends.
class OneDnnLeNet {
 public:
  OneDnnLeNet(const model::LeNetLayers& layers, const model::Weights& weights)
      : engine_(dnnl::engine::kind::cpu, 0), stream_(engine_) {
    const dnnl::memory::dims input{1, 1, layers.input.height, layers.input.width};
    input_ = dnnl::memory({input, Type::f32, Tag::nchw}, engine_);
    dnnl::memory at = input_;
    at = convolution(at, weights[0], weights[1], {1, 6, layers.input.height - 4, layers.input.width - 4});
    at = pooled(at, {1, 6, layers.first_pooled.height, layers.first_pooled.width});
    at = convolution(at, weights[2], weights[3], {1, 16, layers.first_pooled.height - 4, layers.first_pooled.width - 4});
    at = pooled(at, {1, 16, layers.second_pooled.height, layers.second_pooled.width});
    const dnnl::memory::dims kernel{120, 16, layers.second_pooled.height, layers.second_pooled.width};
    at = connected(at, weights[4], weights[5], kernel, true);
    at = connected(at, weights[6], weights[7], {84, 120}, true);
    at = connected(at, weights[8], weights[9], {3, 84}, false);
    output_ = at;
  }

  void classify(const float* heatmap, float* logits) {
    std::copy_n(heatmap, input_.get_desc().get_size() / sizeof(float), static_cast<float*>(input_.get_data_handle()));
    for (std::size_t i = 0; i < steps_.size(); ++i) steps_[i].execute(stream_, arguments_[i]);
    stream_.wait();
    std::copy_n(static_cast<const float*>(output_.get_data_handle()), 3, logits);
  }

 private:
  using Tag = dnnl::memory::format_tag;
  using Type = dnnl::memory::data_type;
  using Desc = dnnl::memory::desc;
  static constexpr auto inference = dnnl::prop_kind::forward_inference;

  static dnnl::primitive_attr with_relu() {
    dnnl::post_ops after;
    after.append_eltwise(1.0F, dnnl::algorithm::eltwise_relu, 0.0F, 0.0F);
    dnnl::primitive_attr attributes;
    attributes.set_post_ops(after);
    return attributes;
  }

  dnnl::memory laid_out(const model::Parameter& parameter, const dnnl::memory::dims& sizes, Tag tag, const Desc& wanted) {
    dnnl::memory plain({sizes, Type::f32, tag}, engine_), result(wanted, engine_);
    std::copy(parameter.values.begin(), parameter.values.end(), static_cast<float*>(plain.get_data_handle()));
    dnnl::reorder(plain, result).execute(stream_, plain, result);
    stream_.wait();
    return result;
  }

  dnnl::memory reordered(const dnnl::memory& at, const Desc& wanted) {
    if (at.get_desc() == wanted) return at;
    const dnnl::memory result(wanted, engine_);
    add(dnnl::reorder(at, result), {{DNNL_ARG_FROM, at}, {DNNL_ARG_TO, result}});
    return result;
  }

  void add(const dnnl::primitive& step, const std::unordered_map<int, dnnl::memory>& arguments) {
    steps_.push_back(step);
    arguments_.push_back(arguments);
  }

  dnnl::memory convolution(const dnnl::memory& at, const model::Parameter& weight, const model::Parameter& bias,
                           const dnnl::memory::dims& out) {
    const dnnl::memory::dims kernel(weight.shape.sizes.begin(), weight.shape.sizes.end());
    const Desc source(at.get_desc().dims(), Type::f32, Tag::any), weights(kernel, Type::f32, Tag::any),
        biases({kernel[0]}, Type::f32, Tag::x), target(out, Type::f32, Tag::any);
    const dnnl::convolution_forward::desc what(inference, dnnl::algorithm::convolution_direct, source, weights, biases, target,
                                               {1, 1}, {0, 0}, {0, 0});
    const dnnl::convolution_forward::primitive_desc chosen(what, with_relu(), engine_);
    const dnnl::memory result(chosen.dst_desc(), engine_);
    add(dnnl::convolution_forward(chosen), {{DNNL_ARG_SRC, reordered(at, chosen.src_desc())},
                                            {DNNL_ARG_WEIGHTS, laid_out(weight, kernel, Tag::oihw, chosen.weights_desc())},
                                            {DNNL_ARG_BIAS, laid_out(bias, {kernel[0]}, Tag::x, chosen.bias_desc())},
                                            {DNNL_ARG_DST, result}});
    return result;
  }

  dnnl::memory pooled(const dnnl::memory& at, const dnnl::memory::dims& out) {
    const Desc target(out, Type::f32, Tag::any);
    const dnnl::pooling_forward::desc what(inference, dnnl::algorithm::pooling_max, at.get_desc(), target, {2, 2}, {2, 2}, {0, 0},
                                           {0, 0});
    const dnnl::pooling_forward::primitive_desc chosen(what, engine_);
    const dnnl::memory result(chosen.dst_desc(), engine_);
    add(dnnl::pooling_forward(chosen), {{DNNL_ARG_SRC, at}, {DNNL_ARG_DST, result}});
    return result;
  }

  dnnl::memory connected(const dnnl::memory& at, const model::Parameter& weight, const model::Parameter& bias,
                         const dnnl::memory::dims& kernel, bool relu) {
    const bool flattens = kernel.size() == 4;
    const Desc source(at.get_desc().dims(), Type::f32, Tag::any), weights(kernel, Type::f32, Tag::any),
        biases({kernel[0]}, Type::f32, Tag::x), target({1, kernel[0]}, Type::f32, Tag::any);
    const dnnl::inner_product_forward::desc what(inference, source, weights, biases, target);
    const dnnl::inner_product_forward::primitive_desc chosen(what, relu ? with_relu() : dnnl::primitive_attr(), engine_);
    const dnnl::memory result(chosen.dst_desc(), engine_);
    add(dnnl::inner_product_forward(chosen),
        {{DNNL_ARG_SRC, reordered(at, chosen.src_desc())},
         {DNNL_ARG_WEIGHTS, laid_out(weight, kernel, flattens ? Tag::oihw : Tag::oi, chosen.weights_desc())},
         {DNNL_ARG_BIAS, laid_out(bias, {kernel[0]}, Tag::x, chosen.bias_desc())},
         {DNNL_ARG_DST, result}});
    return result;
  }

  dnnl::engine engine_;
  dnnl::stream stream_;
  dnnl::memory input_, output_;
  std::vector<dnnl::primitive> steps_;
  std::vector<std::unordered_map<int, dnnl::memory>> arguments_;
};

}  // namespace tactile::bench
#endif
