#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace tactile::model {

/// What predicts.
enum class ModelKind : std::uint8_t {
  lenet,   ///< LeNet on heatmaps
  stream,  ///< a recurrent network on the events of each tick, trained on whole runs
  own,     ///< a network that another program trained, from its TorchScript or ONNX file
};

inline constexpr std::array<std::string_view, 3> kind_names{"lenet", "stream", "own"};
inline constexpr std::span<const std::string_view> trained_kinds = std::span(kind_names).first(2);

std::string_view name_of(ModelKind kind);        ///< "lenet", "stream", "own"
ModelKind kind_named(std::string_view name);     ///< @throws Error
constexpr bool reads_heatmaps(ModelKind kind) {  ///< the others read events
  return kind == ModelKind::lenet;
}

}  // namespace tactile::model
