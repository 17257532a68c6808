#include "tactile/model/bundle/onnx_model.hpp"

#include <fmt/core.h>
#include <onnx/onnx_pb.h>

#include <bit>
#include <initializer_list>

#include "tactile/core/error.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/core/version.hpp"

namespace tactile::model {
namespace {

static_assert(std::endian::native == std::endian::little, "raw_data holds values least byte first");

/// Protobuf's limit is 2 GiB; the difference is enough for the rest of the model.
constexpr std::uint64_t most_weight_bytes = (std::uint64_t{2} << 30) - (std::uint64_t{1} << 20);

constexpr const char* batch = "n";

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

void add_tensor(onnx::GraphProto& graph, const Parameter& parameter) {
  onnx::TensorProto& tensor = *graph.add_initializer();
  tensor.set_name(parameter.shape.name);
  tensor.set_data_type(onnx::TensorProto::FLOAT);
  for (const std::int64_t size : parameter.shape.sizes) tensor.add_dims(size);
  tensor.set_raw_data(parameter.values.data(), parameter.values.size() * sizeof(float));
}

void describe(onnx::ValueInfoProto& value, const std::string& name, const std::string& what,
              std::initializer_list<std::int64_t> sizes) {
  value.set_name(name);
  value.set_doc_string(what);
  onnx::TypeProto::Tensor& type = *value.mutable_type()->mutable_tensor_type();
  type.set_elem_type(onnx::TensorProto::FLOAT);
  type.mutable_shape()->add_dim()->set_dim_param(batch);
  for (const std::int64_t size : sizes) type.mutable_shape()->add_dim()->set_dim_value(size);
}

/// The nodes of a graph. The input of each is the output of the one before.
class Chain {
 public:
  Chain(onnx::GraphProto& graph, std::string input) : graph_(graph), last_(std::move(input)) {}

  onnx::NodeProto& add(const std::string& op, const std::string& name, std::initializer_list<std::string> parameters = {}) {
    onnx::NodeProto& node = *graph_.add_node();
    node.set_op_type(op);
    node.set_name(name);
    node.add_input(last_);
    for (const std::string& parameter : parameters) node.add_input(parameter);
    node.add_output(name);
    last_ = name;
    return node;
  }

 private:
  onnx::GraphProto& graph_;
  std::string last_;
};

void set(onnx::NodeProto& node, const std::string& name, std::int64_t value) {
  onnx::AttributeProto& attribute = *node.add_attribute();
  attribute.set_name(name);
  attribute.set_type(onnx::AttributeProto::INT);
  attribute.set_i(value);
}

void set(onnx::NodeProto& node, const std::string& name, std::initializer_list<std::int64_t> values) {
  onnx::AttributeProto& attribute = *node.add_attribute();
  attribute.set_name(name);
  attribute.set_type(onnx::AttributeProto::INTS);
  for (const std::int64_t value : values) attribute.add_ints(value);
}

std::string operator_of(Activation activation) {
  return activation == Activation::relu ? "Relu" : activation == Activation::tanh ? "Tanh" : "Sigmoid";
}

std::string operator_of(Pooling pooling) { return pooling == Pooling::max ? "MaxPool" : "AveragePool"; }

void add_layers(onnx::GraphProto& graph, const LeNetOptions& options) {
  Chain chain(graph, "heatmaps");
  const auto activate = [&](const std::string& layer) {
    chain.add(operator_of(options.activation), layer + "." + std::string(name_of(options.activation)));
  };
  for (const std::string layer : {"conv1", "conv2"}) {
    onnx::NodeProto& convolution = chain.add("Conv", layer, {layer + ".weight", layer + ".bias"});
    set(convolution, "kernel_shape", {5, 5});
    set(convolution, "strides", {1, 1});
    set(convolution, "pads", {0, 0, 0, 0});
    activate(layer);
    onnx::NodeProto& pool = chain.add(operator_of(options.pooling), layer + ".pool");
    const std::int64_t side = layer == "conv2" ? options.last_pool : 2;
    set(pool, "kernel_shape", {side, side});
    set(pool, "strides", {side, side});  // ONNX rounds sizes down, as the network does
    set(pool, "pads", {0, 0, 0, 0});
  }
  set(chain.add("Flatten", "flat"), "axis", 1);
  for (const std::string layer : {"fc1", "fc2", "fc3"}) {
    const bool is_last = layer == "fc3";
    set(chain.add("Gemm", is_last ? "logits" : layer, {layer + ".weight", layer + ".bias"}), "transB", 1);
    if (!is_last) activate(layer);
  }
  set(chain.add("Softmax", "probabilities"), "axis", 1);
}

}  // namespace

std::string onnx_model(const LeNetLayers& layers, const LeNetOptions& options, const Weights& weights, const std::string& name,
                       const std::map<std::string, std::string>& metadata) {
  check_weights(layers, weights);
  onnx::ModelProto model;
  model.set_ir_version(onnx_ir_version);
  model.add_opset_import()->set_version(onnx_opset);  // of the standard operators, whose domain has no name
  model.set_producer_name("tactile");
  model.set_producer_version(std::string(version()));
  model.set_doc_string(name + ": none, press or slip on the heatmaps of an event-camera tactile sensor");
  for (const auto& [key, value] : metadata) {
    onnx::StringStringEntryProto& entry = *model.add_metadata_props();
    entry.set_key(key);
    entry.set_value(value);
  }
  onnx::GraphProto& graph = *model.mutable_graph();
  graph.set_name("lenet-5");
  const auto classes = static_cast<std::int64_t>(touch_count);
  describe(*graph.add_input(), "heatmaps", "heatmap / 255, in [0, 1]", {1, layers.input.height, layers.input.width});
  describe(*graph.add_output(), "logits", "of none, press, slip", {classes});
  describe(*graph.add_output(), "probabilities", "of none, press, slip: softmax of the logits", {classes});
  add_layers(graph, options);
  for (const Parameter& parameter : weights) add_tensor(graph, parameter);
  return model.SerializeAsString();
}

}  // namespace tactile::model
