#pragma once

#include <cstdint>
#include <string_view>

namespace tactile {

/// What a model is run with.
enum class EngineKind : std::uint8_t {
  fast,      ///< our own (tactile/model/inference/lenet_engine.hpp)
  libtorch,  ///< knows every network that can be trained
};

std::string_view name_of(EngineKind engine);     ///< "fast", "libtorch"
EngineKind engine_named(std::string_view name);  ///< @throws Error

}  // namespace tactile
