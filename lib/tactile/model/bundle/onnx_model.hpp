#pragma once

#include <map>
#include <string>

#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/definition/lenet_layers.hpp"

namespace tactile::model {

/// The version of the operators: ONNX 1.8 (November 2020), supported by onnxruntime from 1.6, TensorRT from 8, OpenVINO and
/// OpenCV's dnn. The network needs nothing newer, and older runtimes do not support newer versions. Source:
/// https://github.com/onnx/onnx/blob/main/docs/Versioning.md, "Released Versions".
inline constexpr int onnx_opset = 13, onnx_ir_version = 7;

/// The network as the bytes of an ONNX model:
///
///   "heatmaps" float32 [n, 1, height, width], heatmap / 255  ->  "logits" float32 [n, 3],  "probabilities" = softmax of these
///
/// for any n >= 1; the weights under their own names.
///
/// @param name      of the model, for display
/// @param metadata  becomes the model's metadata_props
/// @throws Error    if the weights do not fit the layers, or exceed the limit of 2 GiB
/// Source: https://github.com/onnx/onnx/blob/main/docs/IR.md and Operators.md.
std::string onnx_model(const LeNetLayers& layers, const LeNetOptions& options, const Weights& weights, const std::string& name,
                       const std::map<std::string, std::string>& metadata);

}  // namespace tactile::model
