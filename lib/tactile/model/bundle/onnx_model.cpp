#include "tactile/model/bundle/onnx_model.hpp"

#include <fmt/core.h>

#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/model/bundle/onnx_writer.hpp"

namespace tactile::model {
namespace {

/// Protobuf's limit is 2 GiB; the difference is enough for the rest of the model.
constexpr std::uint64_t most_weight_bytes = (std::uint64_t{2} << 30) - (std::uint64_t{1} << 20);

void check_weights(const LeNetLayers& layers, const Weights& weights) {
  if (const std::uint64_t bytes = layers.parameter_count() * sizeof(float); bytes > most_weight_bytes) {
    throw Error(
        fmt::format("ONNX model of heatmaps of {} x {} cells: {} bytes of weights; expected at most {}, because an ONNX file has "
                    "at most 2 GiB",
                    layers.input.width, layers.input.height, bytes, most_weight_bytes));
  }
  const auto shapes = layers.parameters();
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (weights.size() != shapes.size() || weights[i].shape != shapes[i] || weights[i].values.size() != shapes[i].count())
      throw Error("weights: not of this network; expected " + shapes[i].name + " " + nlohmann::json(shapes[i].sizes).dump());
  }
}

std::string operator_of(Activation activation) {
  return activation == Activation::relu ? "Relu" : activation == Activation::tanh ? "Tanh" : "Sigmoid";
}

std::string operator_of(Pooling pooling) { return pooling == Pooling::max ? "MaxPool" : "AveragePool"; }

void add_layers(OnnxWriter& writer, const LeNetOptions& options) {
  std::string last = "heatmaps";
  const auto add = [&](const std::string& op, const std::string& name, const std::string& layer = "") -> onnx::NodeProto& {
    std::vector<std::string> inputs{std::exchange(last, name)};
    if (!layer.empty()) inputs.insert(inputs.end(), {layer + ".weight", layer + ".bias"});
    return writer.add(op, name, inputs);
  };
  const auto activate = [&](const std::string& layer) {
    add(operator_of(options.activation), layer + "." + std::string(name_of(options.activation)));
  };
  for (const std::string layer : {"conv1", "conv2"}) {
    onnx::NodeProto& convolution = add("Conv", layer, layer);
    set(convolution, "kernel_shape", {5, 5});
    set(convolution, "strides", {1, 1});
    set(convolution, "pads", {0, 0, 0, 0});
    activate(layer);
    onnx::NodeProto& pool = add(operator_of(options.pooling), layer + ".pool");
    set(pool, "kernel_shape", {2, 2});
    set(pool, "strides", {2, 2});  // ONNX rounds sizes down, as the network does
    set(pool, "pads", {0, 0, 0, 0});
  }
  set(add("Flatten", "flat"), "axis", 1);
  for (const std::string layer : {"fc1", "fc2", "fc3"}) {
    const bool is_last = layer == "fc3";
    set(add("Gemm", is_last ? "logits" : layer, layer), "transB", 1);
    if (!is_last) activate(layer);
  }
  set(add("Softmax", "probabilities"), "axis", 1);
}

}  // namespace

std::string onnx_model(const LeNetLayers& layers, const LeNetOptions& options, const Weights& weights, const std::string& name,
                       const std::map<std::string, std::string>& metadata) {
  check_weights(layers, weights);
  OnnxWriter writer("lenet-5", name + ": none, press or slip on the heatmaps of an event-camera tactile sensor", metadata);
  constexpr std::int64_t any = OnnxWriter::any, classes = touch_count;
  writer.add_input("heatmaps", "heatmap / 255, in [0, 1]", {any, 1, layers.input.height, layers.input.width});
  writer.add_output("logits", "of none, press, slip", {any, classes});
  writer.add_output("probabilities", "of none, press, slip: softmax of the logits", {any, classes});
  add_layers(writer, options);
  writer.add_tensors(weights);
  return writer.bytes();
}

}  // namespace tactile::model
