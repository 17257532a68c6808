#include "tactile/model/bundle/onnx_stream.hpp"

#include <fmt/core.h>

#include "tactile/core/touch.hpp"
#include "tactile/model/bundle/onnx_writer.hpp"
#include "tactile/model/definition/stream_options.hpp"

namespace tactile::model {
namespace {

using Layout = StreamLayout;
using Sizes = StreamSizes;

constexpr std::int64_t places = Layout::places, cells = Layout::cells_of_place, channels = Sizes::channels,
                       memory = Sizes::memory, classes = touch_count;

/// "mean_5"
std::string mean_name(double span) { return fmt::format("mean_{:g}", span); }

/// Constants of the network's formulas.
void add_constants(OnnxWriter& writer) {
  writer.add_tensor("one", {1}, std::vector<float>{1});
  writer.add_tensor("all_cells", {cells, 1}, std::vector<float>(cells, 1.0F));
  for (const double span : Sizes::spans) {
    writer.add_tensor(mean_name(span) + ".kept_share", {1}, {static_cast<float>(1 - 1 / span)});
    writer.add_tensor(mean_name(span) + ".added_share", {1}, {static_cast<float>(1 / span)});
  }
  constexpr float share = 1.0F / static_cast<float>(Layout::places);
  std::vector<float> positions;
  for (std::size_t place = 0; place < Layout::places; ++place) {
    positions.push_back(share * position_of(place % Layout::across, Layout::across));
    positions.push_back(share * position_of(place / Layout::across, Layout::down));
  }
  writer.add_tensor("place_share", {places, 1}, std::vector<float>(Layout::places, share));
  writer.add_tensor("place_position", {places, 2}, positions);
  writer.add_tensor("one_row", std::vector<std::int64_t>{1, Sizes::pooled});
}

/// relu(weight input + bias)
void add_layer(OnnxWriter& writer, const std::string& name, const std::string& layer, const std::string& input) {
  set(writer.add("Gemm", layer + ".sum", {input, layer + ".weight", layer + ".bias"}), "transB", 1);
  writer.add("Relu", name, {layer + ".sum"});
}

/// From the counts and the means to v, "pooled" [1, 96], and the next means.
void add_places(OnnxWriter& writer) {
  writer.add("Add", "counts.more", {"counts", "one"});
  writer.add("Log", "counts.log", {"counts.more"});
  writer.add("MatMul", "events", {"counts", "all_cells"});
  writer.add("Add", "events.more", {"events", "one"});
  writer.add("Log", "events.log", {"events.more"});
  set(writer.add("Concat", "inputs", {"counts.log", "events.log"}), "axis", 1);
  add_layer(writer, "now", "cells", "inputs");
  std::vector<std::string> kept{"now"};
  for (const double span : Sizes::spans) {
    const std::string mean = mean_name(span);
    writer.add("Mul", mean + ".kept", {mean, mean + ".kept_share"});
    writer.add("Mul", mean + ".added", {"now", mean + ".added_share"});
    writer.add("Add", "next_" + mean, {mean + ".kept", mean + ".added"});
    kept.push_back("next_" + mean);
  }
  set(writer.add("Concat", "kept", kept), "axis", 1);
  add_layer(writer, "hidden", "means", "kept");
  add_layer(writer, "places", "place", "hidden");
  set(writer.add("Transpose", "channels", {"places"}), "perm", {1, 0});
  writer.add("MatMul", "channels.mean", {"channels", "place_share"});
  onnx::NodeProto& most = writer.add("ReduceMax", "channels.most", {"channels"});
  set(most, "axes", std::vector<std::int64_t>{1});
  set(most, "keepdims", 1);
  writer.add("MatMul", "channels.moments", {"channels", "place_position"});
  set(writer.add("Concat", "channels.all", {"channels.mean", "channels.most", "channels.moments"}), "axis", 1);
  set(writer.add("Transpose", "pooled.rows", {"channels.all"}), "perm", {1, 0});
  writer.add("Reshape", "pooled", {"pooled.rows", "one_row"});
}

/// The GRU, in libtorch's form: from "pooled" and "memory" to "next_memory".
void add_memory(OnnxWriter& writer) {
  const auto add_sums = [&](const std::string& name, const std::string& input, const std::string& layer) {
    set(writer.add("Gemm", name, {input, "gru.weight_" + layer, "gru.bias_" + layer}), "transB", 1);
    onnx::NodeProto& gates = writer.add("Split", name + ".reset", {name});
    set(gates, "axis", 1);
    for (const char* gate : {".update", ".new"}) gates.add_output(name + gate);
  };
  add_sums("input", "pooled", "ih");
  add_sums("own", "memory", "hh");
  for (const std::string gate : {"reset", "update"}) {
    writer.add("Add", gate + ".sum", {"input." + gate, "own." + gate});
    writer.add("Sigmoid", gate, {gate + ".sum"});
  }
  writer.add("Mul", "own.reset_new", {"reset", "own.new"});
  writer.add("Add", "fresh.sum", {"input.new", "own.reset_new"});
  writer.add("Tanh", "fresh", {"fresh.sum"});
  writer.add("Sub", "memory.over_fresh", {"memory", "fresh"});
  writer.add("Mul", "memory.kept", {"update", "memory.over_fresh"});
  writer.add("Add", "next_memory", {"fresh", "memory.kept"});
}

}  // namespace

std::vector<NetworkState> stream_states() {
  std::vector<NetworkState> states;
  states.reserve(Sizes::spans.size() + 1);
  for (const double span : Sizes::spans) states.push_back({mean_name(span), "next_" + mean_name(span), {places, channels}});
  states.push_back({"memory", "next_memory", {1, memory}});
  return states;
}

std::string onnx_stream(const Weights& weights, const std::string& name, const std::map<std::string, std::string>& metadata) {
  check_shapes(weights, stream_parameters(), "weights: not of a model of kind stream");
  OnnxWriter writer("stream", name + ": none, press or slip on the events of a tick of an event-camera tactile sensor", metadata);
  writer.add_input("counts", "events of the tick, by place and cell", {places, cells});
  for (const NetworkState& state : stream_states())
    writer.add_input(state.input, state.output + " of the tick before; 0 at the start", state.shape);
  writer.add_output("logits", "of none, press, slip", {1, classes});
  writer.add_output("probabilities", "of none, press, slip: softmax of the logits", {1, classes});
  for (const NetworkState& state : stream_states())
    writer.add_output(state.output, state.input + " of the next tick", state.shape);
  add_constants(writer);
  writer.add_tensors({weights.begin() + 1, weights.end()});  // without the grid
  add_places(writer);
  add_memory(writer);
  set(writer.add("Gemm", "logits", {"next_memory", "out.weight", "out.bias"}), "transB", 1);
  set(writer.add("Softmax", "probabilities", {"logits"}), "axis", 1);
  return writer.bytes();
}

}  // namespace tactile::model
