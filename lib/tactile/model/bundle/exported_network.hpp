#pragma once

#include "tactile/model/bundle/model_bundle.hpp"

namespace tactile::model {

/// What the ONNX file of an exported model reads and gives: `eval` and `detect` take such a file with its description.
/// @throws Error  if a model of this kind has no such file: it is neither `lenet` nor `stream`
OwnDescription exported_description(const ModelDescription& model, const Weights& weights, double temperature);

/// The model as the bytes of its ONNX file: `onnx_model` or `onnx_stream`. @throws Error  as these
std::string exported_onnx(const ModelDescription& model, const Weights& weights, const std::string& name,
                          const std::map<std::string, std::string>& metadata);

}  // namespace tactile::model
