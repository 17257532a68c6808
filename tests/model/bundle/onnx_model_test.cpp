#include "tactile/model/bundle/onnx_model.hpp"

#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/dnn.hpp>
#include <set>
#include <string>
#include <tuple>

#include "model/noise_heatmaps.hpp"
#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/training/lenet.hpp"

namespace tactile::model {
namespace {

using test::noise_heatmaps;

/// Values of any number of dimensions, the last running fastest.
struct Tensor {
  std::vector<std::int64_t> sizes;
  std::vector<double> values;
};

Tensor blank(std::vector<std::int64_t> sizes) {
  std::size_t count = 1;
  for (const std::int64_t size : sizes) count *= static_cast<std::size_t>(size);
  return {std::move(sizes), std::vector<double>(count)};
}

std::map<std::string, onnx::AttributeProto> attributes_of(const onnx::NodeProto& node) {
  std::map<std::string, onnx::AttributeProto> attributes;
  for (const onnx::AttributeProto& attribute : node.attribute()) attributes[attribute.name()] = attribute;
  return attributes;
}

/// A list that an operator's attribute gives, or ONNX's default.
std::vector<std::int64_t> ints_of(const onnx::NodeProto& node, const std::string& name, std::vector<std::int64_t> usual) {
  const auto attributes = attributes_of(node);
  const auto found = attributes.find(name);
  if (found == attributes.end()) return usual;
  return {found->second.ints().begin(), found->second.ints().end()};
}

std::int64_t int_of(const onnx::NodeProto& node, const std::string& name, std::int64_t usual) {
  const auto attributes = attributes_of(node);
  const auto found = attributes.find(name);
  return found == attributes.end() ? usual : found->second.i();
}

/// Goes over the windows of a picture's channels, without padding, sizes rounded down.
template <class Value>
Tensor over_windows(const onnx::NodeProto& node, const Tensor& in, std::int64_t channels, std::vector<std::int64_t> kernel,
                    const Value& value) {
  EXPECT_EQ(ints_of(node, "pads", {0, 0, 0, 0}), (std::vector<std::int64_t>{0, 0, 0, 0}));
  EXPECT_EQ(ints_of(node, "dilations", {1, 1}), (std::vector<std::int64_t>{1, 1}));
  EXPECT_EQ(int_of(node, "ceil_mode", 0), 0);
  EXPECT_EQ(int_of(node, "group", 1), 1);
  EXPECT_EQ(ints_of(node, "kernel_shape", kernel), kernel);
  const auto strides = ints_of(node, "strides", {1, 1});
  Tensor out =
      blank({in.sizes[0], channels, (in.sizes[2] - kernel[0]) / strides[0] + 1, (in.sizes[3] - kernel[1]) / strides[1] + 1});
  std::size_t i = 0;
  for (std::int64_t n = 0; n < out.sizes[0]; ++n) {
    for (std::int64_t c = 0; c < channels; ++c) {
      for (std::int64_t y = 0; y < out.sizes[2]; ++y) {
        for (std::int64_t x = 0; x < out.sizes[3]; ++x) out.values[i++] = value(n, c, y * strides[0], x * strides[1]);
      }
    }
  }
  return out;
}

double at(const Tensor& t, std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d) {
  return t.values[static_cast<std::size_t>(((a * t.sizes[1] + b) * t.sizes[2] + c) * t.sizes[3] + d)];
}

Tensor convolved(const onnx::NodeProto& node, const Tensor& in, const Tensor& weight, const Tensor& bias) {
  const std::vector<std::int64_t> kernel{weight.sizes[2], weight.sizes[3]};
  return over_windows(node, in, weight.sizes[0], kernel, [&](std::int64_t n, std::int64_t c, std::int64_t y, std::int64_t x) {
    double sum = bias.values[static_cast<std::size_t>(c)];
    for (std::int64_t k = 0; k < in.sizes[1]; ++k) {
      for (std::int64_t dy = 0; dy < kernel[0]; ++dy) {
        for (std::int64_t dx = 0; dx < kernel[1]; ++dx) sum += at(weight, c, k, dy, dx) * at(in, n, k, y + dy, x + dx);
      }
    }
    return sum;
  });
}

Tensor pooled(const onnx::NodeProto& node, const Tensor& in, bool largest) {
  const auto kernel = ints_of(node, "kernel_shape", {});
  return over_windows(node, in, in.sizes[1], kernel, [&](std::int64_t n, std::int64_t c, std::int64_t y, std::int64_t x) {
    double sum = 0, most = -HUGE_VAL;
    for (std::int64_t dy = 0; dy < kernel[0]; ++dy) {
      for (std::int64_t dx = 0; dx < kernel[1]; ++dx) {
        sum += at(in, n, c, y + dy, x + dx);
        most = std::max(most, at(in, n, c, y + dy, x + dx));
      }
    }
    return largest ? most : sum / static_cast<double>(kernel[0] * kernel[1]);
  });
}

Tensor connected(const onnx::NodeProto& node, const Tensor& in, const Tensor& weight, const Tensor& bias) {
  EXPECT_EQ(int_of(node, "transA", 0), 0);
  EXPECT_EQ(int_of(node, "transB", 0), 1);
  EXPECT_EQ(attributes_of(node).count("alpha") + attributes_of(node).count("beta"), 0U);
  EXPECT_EQ(in.sizes[1], weight.sizes[1]);
  Tensor out = blank({in.sizes[0], weight.sizes[0]});
  const auto width = static_cast<std::size_t>(weight.sizes[1]), outputs = static_cast<std::size_t>(weight.sizes[0]);
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    const std::size_t n = i / outputs, o = i % outputs;
    out.values[i] = bias.values[o];
    for (std::size_t k = 0; k < width; ++k) out.values[i] += weight.values[o * width + k] * in.values[n * width + k];
  }
  return out;
}

Tensor softmax(const onnx::NodeProto& node, Tensor x) {
  EXPECT_EQ(int_of(node, "axis", -1), 1);
  const auto width = static_cast<std::size_t>(x.sizes[1]);
  for (std::size_t row = 0; row < x.values.size(); row += width) {
    double sum = 0;
    for (std::size_t k = row; k < row + width; ++k) sum += x.values[k] = std::exp(x.values[k]);
    for (std::size_t k = row; k < row + width; ++k) x.values[k] /= sum;
  }
  return x;
}

template <class Function>
Tensor each(Tensor x, const Function& function) {
  std::transform(x.values.begin(), x.values.end(), x.values.begin(), function);
  return x;
}

Tensor result_of(const onnx::NodeProto& node, const std::map<std::string, Tensor>& known) {
  const std::string& op = node.op_type();
  const Tensor& in = known.at(node.input(0));
  if (op == "Conv") return convolved(node, in, known.at(node.input(1)), known.at(node.input(2)));
  if (op == "Gemm") return connected(node, in, known.at(node.input(1)), known.at(node.input(2)));
  if (op == "MaxPool" || op == "AveragePool") return pooled(node, in, op == "MaxPool");
  if (op == "Relu") return each(in, [](double x) { return std::max(x, 0.0); });
  if (op == "Tanh") return each(in, [](double x) { return std::tanh(x); });
  if (op == "Sigmoid") return each(in, [](double x) { return 1 / (1 + std::exp(-x)); });
  if (op == "Softmax") return softmax(node, in);
  EXPECT_EQ(op, "Flatten");
  EXPECT_EQ(int_of(node, "axis", 1), 1);
  return {{in.sizes[0], static_cast<std::int64_t>(in.values.size()) / in.sizes[0]}, in.values};
}

/// Everything that the graph computes, by ONNX's own definition of its operators.
std::map<std::string, Tensor> evaluated(const onnx::ModelProto& model, Tensor heatmaps) {
  std::map<std::string, Tensor> known{{"heatmaps", std::move(heatmaps)}};
  for (const onnx::TensorProto& tensor : model.graph().initializer()) {
    Tensor& weight = known[tensor.name()] = blank({tensor.dims().begin(), tensor.dims().end()});
    std::vector<float> values(weight.values.size());
    if (tensor.raw_data().size() != values.size() * sizeof(float)) {
      ADD_FAILURE() << tensor.name() << ": " << tensor.raw_data().size() << " bytes";
      return known;
    }
    std::memcpy(values.data(), tensor.raw_data().data(), tensor.raw_data().size());
    weight.values.assign(values.begin(), values.end());
  }
  for (const onnx::NodeProto& node : model.graph().node()) known[node.output(0)] = result_of(node, known);
  return known;
}

std::string bytes_of(const LeNet& network, const LeNetOptions& options, const std::map<std::string, std::string>& metadata = {}) {
  return onnx_model(network.layers(), options, network.weights(), "test", metadata);
}

onnx::ModelProto parsed(const std::string& bytes) {
  onnx::ModelProto model;
  EXPECT_TRUE(model.ParseFromString(bytes));
  return model;
}

using Choice = std::tuple<Activation, Pooling>;

class EveryNetwork : public testing::TestWithParam<Choice> {
 protected:
  LeNetOptions options() const { return {std::get<0>(GetParam()), std::get<1>(GetParam())}; }
};

std::string name_of_choice(const testing::TestParamInfo<Choice>& info) {
  return std::string(name_of(std::get<0>(info.param))) + "_" + std::string(name_of(std::get<1>(info.param)));
}

INSTANTIATE_TEST_SUITE_P(OnnxModel, EveryNetwork,
                         testing::Combine(testing::Values(Activation::relu, Activation::tanh, Activation::sigmoid),
                                          testing::Values(Pooling::max, Pooling::average)),
                         name_of_choice);

Tensor input_of(const test::NoiseHeatmaps& noise) {
  Tensor input = blank({static_cast<std::int64_t>(noise.truth.size()), 1, noise.size.height, noise.size.width});
  std::transform(noise.heatmaps.begin(), noise.heatmaps.end(), input.values.begin(),
                 [](std::uint8_t cell) { return cell / 255.0; });
  return input;
}

TEST_P(EveryNetwork, EvaluatedByTheOperatorsDefinitionsGivesTheNetworksLogits) {
  for (const events::SensorSize size : {events::SensorSize{128, 96}, events::SensorSize{31, 22}, events::SensorSize{16, 16}}) {
    const auto noise = noise_heatmaps(3, size, 5);
    const LeNet network(size, 1, options());
    const auto logits = network.logits(noise.heatmaps, 1);
    const auto found = evaluated(parsed(bytes_of(network, options())), input_of(noise));
    const Tensor& outputs = found.at("logits");
    const Tensor& probabilities = found.at("probabilities");
    ASSERT_EQ(outputs.sizes, (std::vector<std::int64_t>{3, 3}));
    ASSERT_EQ(probabilities.sizes, outputs.sizes);
    for (std::size_t n = 0; n < logits.size(); ++n) {
      double sum = 0;
      for (const float logit : logits[n]) sum += std::exp(static_cast<double>(logit));
      for (std::size_t k = 0; k < touch_count; ++k) {
        EXPECT_NEAR(outputs.values[n * touch_count + k], logits[n][k], 1e-5) << "heatmap " << n << ", logit " << k;
        EXPECT_NEAR(probabilities.values[n * touch_count + k], std::exp(static_cast<double>(logits[n][k])) / sum, 1e-5);
      }
    }
  }
}

TEST_P(EveryNetwork, IsReadByOpenCVsRuntimeWithTheSameLogitsForAnyBatch) {
  const events::SensorSize size{64, 48};
  const LeNet network(size, 2, options());
  const std::string bytes = bytes_of(network, options());
  cv::dnn::Net net = cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
  for (const std::size_t count : {std::size_t{1}, std::size_t{5}}) {
    const auto noise = noise_heatmaps(count, size, 6);
    const auto logits = network.logits(noise.heatmaps, 1);
    const std::array<int, 4> sizes{static_cast<int>(count), 1, size.height, size.width};
    cv::Mat input(4, sizes.data(), CV_32F);
    std::transform(noise.heatmaps.begin(), noise.heatmaps.end(), input.ptr<float>(),
                   [](std::uint8_t cell) { return static_cast<float>(cell) / 255.0F; });
    net.setInput(input, "heatmaps");
    const cv::Mat found = net.forward("logits");
    ASSERT_EQ(found.total(), count * touch_count);
    for (std::size_t i = 0; i < found.total(); ++i)
      EXPECT_NEAR(found.ptr<float>()[i], logits[i / touch_count][i % touch_count], 1e-4);
  }
}

TEST_P(EveryNetwork, DescribesItself) {
  const onnx::ModelProto model = parsed(bytes_of(LeNet({32, 24}, 3, options()), options(), {{"classes", "[1]"}, {"input", "x"}}));
  EXPECT_EQ(model.ir_version(), 7);
  ASSERT_EQ(model.opset_import_size(), 1);
  EXPECT_EQ(model.opset_import(0).version(), 13);
  EXPECT_EQ(model.opset_import(0).domain(), "");
  EXPECT_EQ(model.producer_name(), "tactile");
  std::map<std::string, std::string> metadata;
  for (const auto& entry : model.metadata_props()) metadata[entry.key()] = entry.value();
  EXPECT_EQ(metadata, (std::map<std::string, std::string>{{"classes", "[1]"}, {"input", "x"}}));

  const onnx::GraphProto& graph = model.graph();
  std::vector<std::string> operators;
  std::set<std::string> known{"heatmaps"}, nodes;
  for (const onnx::TensorProto& tensor : graph.initializer()) {
    EXPECT_EQ(tensor.data_type(), onnx::TensorProto::FLOAT);
    EXPECT_TRUE(known.insert(tensor.name()).second) << tensor.name();
  }
  for (const onnx::NodeProto& node : graph.node()) {
    operators.push_back(node.op_type());
    EXPECT_TRUE(nodes.insert(node.name()).second) << node.name();
    for (const std::string& input : node.input()) EXPECT_EQ(known.count(input), 1U) << input << ", used before it is known";
    for (const std::string& output : node.output()) EXPECT_TRUE(known.insert(output).second) << output << ", made twice";
  }
  const std::string a = options().activation == Activation::relu   ? "Relu"
                        : options().activation == Activation::tanh ? "Tanh"
                                                                   : "Sigmoid";
  const std::string p = options().pooling == Pooling::max ? "MaxPool" : "AveragePool";
  EXPECT_EQ(operators,
            (std::vector<std::string>{"Conv", a, p, "Conv", a, p, "Flatten", "Gemm", a, "Gemm", a, "Gemm", "Softmax"}));
}

/// "n,1,24,32"
std::string sizes_of(const onnx::ValueInfoProto& value) {
  std::string text;
  for (const auto& dim : value.type().tensor_type().shape().dim())
    text += (text.empty() ? "" : ",") + (dim.has_dim_param() ? dim.dim_param() : std::to_string(dim.dim_value()));
  return text;
}

TEST(OnnxModel, TakesHeatmapsOfItsSizeAndAsManyAsOneLikes) {
  const onnx::GraphProto graph = parsed(bytes_of(LeNet({32, 24}, 3), {})).graph();
  ASSERT_EQ(graph.input_size(), 1);  // weights are no inputs
  ASSERT_EQ(graph.output_size(), 2);
  EXPECT_EQ(graph.input(0).name(), "heatmaps");
  EXPECT_EQ(sizes_of(graph.input(0)), "n,1,24,32");
  EXPECT_EQ(graph.output(0).name(), "logits");
  EXPECT_EQ(graph.output(1).name(), "probabilities");
  for (const onnx::ValueInfoProto& output : graph.output()) EXPECT_EQ(sizes_of(output), "n,3");
  EXPECT_EQ(graph.input(0).type().tensor_type().elem_type(), onnx::TensorProto::FLOAT);
}

TEST(OnnxModel, IsTheSameBytesForTheSameNetwork) {
  const std::map<std::string, std::string> metadata{{"a", "1"}, {"b", "2"}};
  EXPECT_EQ(bytes_of(LeNet({32, 24}, 3), {}, metadata), bytes_of(LeNet({32, 24}, 3), {}, metadata));
  EXPECT_NE(bytes_of(LeNet({32, 24}, 3), {}, metadata), bytes_of(LeNet({32, 24}, 4), {}, metadata));
}

TEST(OnnxModel, RefusesWeightsOfAnotherNetwork) {
  Weights weights = LeNet({32, 24}, 3).weights();
  const auto error = [&](events::SensorSize size) {
    return test::error_of([&] { onnx_model(lenet_layers(size), {}, weights, "test", {}); });
  };
  EXPECT_NE(error({40, 24}).find("fc1.weight [120,336]"), std::string::npos) << error({40, 24});
  weights.pop_back();
  EXPECT_NE(error({32, 24}).find("not of this network"), std::string::npos);
}

TEST(OnnxModel, RefusesMoreThanAFileMayHold) {
  // 16 x 1021 x 1021 values go into each of 120 units: 8 GB, of which nothing is allocated here.
  Weights weights;
  for (const ParameterShape& shape : lenet_layers({4096, 4096}).parameters()) weights.push_back({shape, {}});
  const std::string error = test::error_of([&] { onnx_model(lenet_layers({4096, 4096}), {}, weights, "test", {}); });
  EXPECT_NE(error.find("2 GiB"), std::string::npos) << error;
}

TEST(OnnxModel, PassesOnnxsOwnChecker) {
  if (test::run_shell("/usr/bin/python3 -c 'import onnx'").exit_code != 0)
    GTEST_SKIP()
        << "SKIPPED: ONNX's checker did not look at the models, for python3-onnx is not installed; scripts/setup does it";
  const test::TemporaryFolder folder;
  for (const Activation activation : {Activation::relu, Activation::tanh, Activation::sigmoid}) {
    for (const Pooling pooling : {Pooling::max, Pooling::average})
      write_whole(folder / (std::string(name_of(activation)) + "-" + std::string(name_of(pooling)) + ".onnx"),
                  bytes_of(LeNet({31, 22}, 3, {activation, pooling}), {activation, pooling}, {{"classes", "[]"}}));
  }
  write_whole(folder / "check.py",
              "import sys, onnx\n"
              "for file in sys.argv[1:]:\n"
              "    model = onnx.load(file)\n"
              "    onnx.checker.check_model(model, full_check=True)\n"
              "    whole = onnx.shape_inference.infer_shapes(model, check_type=True, strict_mode=True)\n"
              "    flat = [v for v in whole.graph.value_info if v.name == 'flat'][0].type.tensor_type.shape.dim\n"
              "    print(flat[0].dim_param, flat[1].dim_value)\n");
  const auto checked = test::run_shell("/usr/bin/python3 check.py *.onnx", folder.path());
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  std::string expected;
  for (int i = 0; i < 6; ++i) expected += "n " + std::to_string(lenet_layers({31, 22}).flat) + "\n";
  EXPECT_EQ(checked.out, expected);
}

}  // namespace
}  // namespace tactile::model
