#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace tactile::model {

/// The inference engine.
enum class EngineKind : std::uint8_t {
  fast,      ///< the built-in engine (tactile/model/inference/lenet_engine.hpp)
  libtorch,  ///< supports every network that can be trained
  opencv,    ///< OpenCV's dnn: of ONNX files that another program made
};

inline constexpr std::array<std::string_view, 3> engine_names{"fast", "libtorch", "opencv"};
inline constexpr std::span<const std::string_view> training_engines = std::span(engine_names).first(2);

std::string_view name_of(EngineKind engine);     ///< "fast", "libtorch", "opencv"
EngineKind engine_named(std::string_view name);  ///< @throws Error

}  // namespace tactile::model
