#pragma once

#include <map>
#include <string>
#include <vector>

#include "tactile/model/bundle/own_description.hpp"
#include "tactile/model/bundle/weights.hpp"

namespace tactile::model {

/// The states of `onnx_stream`.
std::vector<NetworkState> stream_states();

/// The network of kind `stream` (model/inference/stream_network.hpp) as the bytes of an ONNX model. One call is one tick:
///
///   "counts" float32 [9, 144], the events of the tick by place and cell, as `StreamLayout` orders them,
///   "mean_5", "mean_20", "mean_80" [9, 24], a_p of the ticks so far averaged over so many ticks, "memory" [1, 40]
///     ->  "logits" [1, 3], "probabilities" [1, 3] = softmax of these, "next_mean_5", … "next_memory"
///
/// The weights have their own names; "grid" is left out, since it makes the counts. The versions are those of `onnx_model`, and
/// OpenCV's dnn 4.6 reads the operators.
///
/// @param name      of the model, for display
/// @param metadata  becomes the model's metadata_props
/// @throws Error    if the weights are not those of a stream
std::string onnx_stream(const Weights& weights, const std::string& name, const std::map<std::string, std::string>& metadata);

}  // namespace tactile::model
