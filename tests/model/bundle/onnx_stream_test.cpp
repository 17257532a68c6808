#include "tactile/model/bundle/onnx_stream.hpp"

#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <map>
#include <opencv2/dnn.hpp>
#include <set>

#include "model/stream_data.hpp"
#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/inference/stream_network.hpp"

namespace tactile::model {
namespace {

/// Runs an exported network by OpenCV's dnn, tick by tick.
class StreamOnOpenCv {
 public:
  explicit StreamOnOpenCv(const std::string& bytes) : net_(cv::dnn::readNetFromONNX(bytes.data(), bytes.size())) {
    for (const NetworkState& state : stream_states())
      states_.push_back(cv::Mat::zeros(static_cast<int>(state.shape[0]), static_cast<int>(state.shape[1]), CV_32F));
  }

  Logits advance(std::span<const std::uint8_t> counts) {
    cv::Mat input(StreamLayout::places, StreamLayout::cells_of_place, CV_32F);
    std::copy(counts.begin(), counts.end(), input.ptr<float>());
    net_.setInput(input, "counts");
    std::vector<cv::String> outputs{"logits"};
    for (std::size_t i = 0; i < states_.size(); ++i) {
      net_.setInput(states_[i], stream_states()[i].input);
      outputs.push_back(stream_states()[i].output);
    }
    std::vector<cv::Mat> found;
    net_.forward(found, outputs);
    for (std::size_t i = 0; i < states_.size(); ++i) states_[i] = found[i + 1].clone();
    Logits logits{};
    EXPECT_EQ(found.front().total(), logits.size());
    std::copy_n(found.front().ptr<float>(), logits.size(), logits.begin());
    return logits;
  }

 private:
  cv::dnn::Net net_;
  std::vector<cv::Mat> states_;
};

/// Counts the events of a tick as the engine does: an event in the middle of its cell.
void count(StreamCounts& counted, std::span<const std::uint8_t> counts) {
  counted.clear();
  for (std::size_t polarity = 0; polarity < 2; ++polarity) {
    for (std::size_t row = 0; row < StreamLayout::all_rows; ++row) {
      for (std::size_t column = 0; column < StreamLayout::all_columns; ++column) {
        const events::Event event{CameraTime{}, static_cast<std::int16_t>(column * 160 / StreamLayout::all_columns + 5),
                                  static_cast<std::int16_t>(row * 120 / StreamLayout::all_rows + 1),
                                  static_cast<std::uint8_t>(polarity)};
        for (int i = counts[StreamLayout::cell(polarity, row, column)]; i > 0; --i) counted.count(event);
      }
    }
  }
}

TEST(OnnxStream, IsRunByOpenCVsRuntimeWithTheEnginesLogitsTickAfterTick) {
  constexpr std::size_t ticks = 1'500;
  for (const std::uint64_t seed : {1U, 2U}) {
    const Weights weights = test::stream_weights(seed);
    const StreamNetwork engine(weights);
    StreamState state;
    StreamCounts counted({160, 120}, engine.grid());
    StreamOnOpenCv exported(onnx_stream(weights, "test", {}));
    std::vector<std::uint8_t> counts = test::stream_counts(ticks, seed);
    // A pause, in which the engine comes to rest, and a tick with many events.
    std::fill(counts.begin() + 300 * StreamLayout::cells, counts.begin() + 1'300 * StreamLayout::cells, std::uint8_t{0});
    std::fill_n(counts.begin() + 200 * StreamLayout::cells, StreamLayout::cells, std::uint8_t{255});
    for (std::size_t tick = 0; tick < ticks; ++tick) {
      const auto of_tick = std::span(counts).subspan(tick * StreamLayout::cells, StreamLayout::cells);
      count(counted, of_tick);
      engine.advance(counted, state);
      const Logits logits = exported.advance(of_tick);
      for (std::size_t k = 0; k < touch_count; ++k) ASSERT_NEAR(logits[k], state.logits[k], 1e-5) << "tick " << tick;
    }
  }
}

/// "9,144"
std::string shape_of(const onnx::ValueInfoProto& value) {
  std::string text;
  for (const auto& dim : value.type().tensor_type().shape().dim())
    text += (text.empty() ? "" : ",") + std::to_string(dim.dim_value());
  return text;
}

TEST(OnnxStream, DescribesItsInputsAndOutputs) {
  onnx::ModelProto model;
  ASSERT_TRUE(model.ParseFromString(onnx_stream(test::stream_weights(), "test", {{"classes", "[1]"}})));
  EXPECT_EQ(model.opset_import(0).version(), 13);
  EXPECT_EQ(model.metadata_props(0).key(), "classes");
  std::map<std::string, std::string> inputs, outputs;
  for (const auto& input : model.graph().input()) inputs[input.name()] = shape_of(input);
  for (const auto& output : model.graph().output()) outputs[output.name()] = shape_of(output);
  EXPECT_EQ(inputs, (std::map<std::string, std::string>{
                        {"counts", "9,144"}, {"mean_5", "9,24"}, {"mean_20", "9,24"}, {"mean_80", "9,24"}, {"memory", "1,40"}}));
  EXPECT_EQ(outputs, (std::map<std::string, std::string>{{"logits", "1,3"},
                                                         {"probabilities", "1,3"},
                                                         {"next_mean_5", "9,24"},
                                                         {"next_mean_20", "9,24"},
                                                         {"next_mean_80", "9,24"},
                                                         {"next_memory", "1,40"}}));
  std::set<std::string> known;
  for (const auto& tensor : model.graph().initializer()) EXPECT_TRUE(known.insert(tensor.name()).second) << tensor.name();
  for (const ParameterShape& shape : stream_parameters())
    EXPECT_EQ(known.contains(shape.name), shape.name != "grid") << shape.name;
  Weights weights = test::stream_weights();
  weights.pop_back();
  EXPECT_NE(test::error_of([&] { onnx_stream(weights, "test", {}); }).find("not of a model of kind stream"), std::string::npos);
}

TEST(OnnxStream, PassesTheCheckerOfOnnxWithItsShapes) {
  if (test::run_shell("/usr/bin/python3 -c 'import onnx'").exit_code != 0)
    GTEST_SKIP() << "SKIPPED: ONNX's checker did not look at the model, for python3-onnx is not installed; scripts/setup does it";
  const test::TemporaryFolder folder;
  write_whole(folder / "m.onnx", onnx_stream(test::stream_weights(), "test", {}));
  write_whole(folder / "check.py",
              "import onnx\n"
              "model = onnx.load('m.onnx')\n"
              "onnx.checker.check_model(model, full_check=True)\n"
              "onnx.shape_inference.infer_shapes(model, check_type=True, strict_mode=True)\n");
  const auto checked = test::run_shell("/usr/bin/python3 check.py", folder.path());
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
}

}  // namespace
}  // namespace tactile::model
