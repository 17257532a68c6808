#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/fields.hpp"
#include "tactile/events/event.hpp"

namespace tactile::model {

/// A parameter of the network: its name in the weights file, and its sizes, outermost first.
struct ParameterShape {
  std::string name;
  std::vector<std::int64_t> sizes;

  std::size_t count() const;  ///< number of values

  friend bool operator==(const ParameterShape&, const ParameterShape&) = default;
};

/// The function after each layer except the last.
enum class Activation : std::uint8_t { relu, tanh, sigmoid };
inline constexpr std::array<std::string_view, 3> activation_names{"relu", "tanh", "sigmoid"};
constexpr std::string_view name_of(Activation activation) { return activation_names.at(static_cast<std::size_t>(activation)); }
/// The reduction of 2 x 2 values to one.
enum class Pooling : std::uint8_t { max, average };
inline constexpr std::array<std::string_view, 2> pooling_names{"max", "average"};
constexpr std::string_view name_of(Pooling pooling) { return pooling_names.at(static_cast<std::size_t>(pooling)); }

/// Options of the network; the defaults are the paper's.
struct LeNetOptions {
  Activation activation = Activation::relu;
  Pooling pooling = Pooling::max;

  bool is_fast() const;  ///< whether the fast engine supports it: ReLU and max-pooling

  friend bool operator==(const LeNetOptions&, const LeNetOptions&) = default;
};

template <class Fields>
void list_fields(Fields& fields, LeNetOptions& o) {
  fields("activation", o.activation, activation_names, {"activation", "Activation function"});
  fields("pool", o.pooling, pooling_names, {"pool", "Pooling"});
}

/// LeNet-5 for heatmaps of one size:
///
///   conv 6@5x5 (stride 1, no padding), ReLU, max-pool 2 (floor), conv 16@5x5, ReLU, max-pool 2, flatten channel first,
///   fully connected 120, ReLU, 84, ReLU, then one logit for each touch
///
/// LeNetOptions may select another activation or pooling, which keep the shapes.
///
/// Source: LeCun et al., 1998, as Faris et al., arXiv:2403.10120, use it.
struct LeNetLayers {
  static constexpr std::size_t first_channels = 6, second_channels = 16, first_hidden = 120, second_hidden = 84;

  events::SensorSize input;          ///< of a heatmap [cells]
  events::SensorSize first_pooled;   ///< after the first pooling
  events::SensorSize second_pooled;  ///< after the second pooling
  std::size_t flat = 0;              ///< values after flattening; 9744 for 128 x 96

  /// In the order of the layers, weight before bias: "conv1.weight" [6, 1, 5, 5], "conv1.bias" [6], ... "fc3.bias" [3].
  std::vector<ParameterShape> parameters() const;
  std::size_t parameter_count() const;  ///< number of all values
};

/// @throws Error  if the heatmap is too small for the layers (at least 16 x 16 cells) or larger than 4096 cells in a direction
LeNetLayers lenet_layers(events::SensorSize input);

/// The number of consecutive heatmaps of this size. @throws Error  if it is not a whole number
std::size_t heatmap_count(std::span<const std::uint8_t> heatmaps, events::SensorSize size);

/// A description of the layers and options for a bundle's model.json.
nlohmann::json json_of(const LeNetLayers& layers, const LeNetOptions& options);

}  // namespace tactile::model
