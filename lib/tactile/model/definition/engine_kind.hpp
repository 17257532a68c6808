#pragma once

#include <cstdint>
#include <string_view>

namespace tactile::model {

/// The inference engine.
enum class EngineKind : std::uint8_t {
  fast,      ///< the built-in engine (tactile/model/inference/lenet_engine.hpp)
  libtorch,  ///< supports every network that can be trained
  opencv,    ///< OpenCV's dnn: of ONNX files that another program made
};

std::string_view name_of(EngineKind engine);     ///< "fast", "libtorch", "opencv"
EngineKind engine_named(std::string_view name);  ///< @throws Error

}  // namespace tactile::model
