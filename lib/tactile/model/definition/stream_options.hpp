#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "tactile/core/fields.hpp"
#include "tactile/core/time.hpp"
#include "tactile/model/definition/lenet_layers.hpp"

namespace tactile::model {

/// How the network of kind `stream` sees the events of a tick: a rectangle of the sensor is cut into `across` x `down` places,
/// each of `columns` x `rows` cells, and the events of each cell are counted, OFF and ON apart.
struct StreamLayout {
  static constexpr std::size_t across = 3, down = 3, columns = 4, rows = 18;
  static constexpr std::size_t places = across * down;
  static constexpr std::size_t cells_of_place = 2 * rows * columns;   ///< [polarity, row, column]
  static constexpr std::size_t inputs_of_place = cells_of_place + 1;  ///< of the network: of its counts, and of their sum
  static constexpr std::size_t cells = places * cells_of_place;       ///< [place, polarity, row, column]
  static constexpr std::size_t all_columns = across * columns, all_rows = down * rows;

  /// The cell of a polarity, a row from the top and a column from the left.
  static constexpr std::size_t cell(std::size_t polarity, std::size_t row, std::size_t column) {
    const std::size_t place = row / rows * across + column / columns;
    return place * cells_of_place + (polarity * rows + row % rows) * columns + column % columns;
  }
};

/// Position of a place along an axis of `count` places: from -1 to 1.
constexpr float position_of(std::size_t index, std::size_t count) {
  return count < 2 ? 0.0F : static_cast<float>(2 * index) / static_cast<float>(count - 1) - 1.0F;
}

/// Sizes of the network of kind `stream`.
struct StreamSizes {
  static constexpr std::size_t channels = 24;               ///< of a place
  static constexpr std::array<double, 3> spans{5, 20, 80};  ///< of its running means [ticks]
  static constexpr std::size_t kept = 1 + spans.size();     ///< a place's value of this tick, and its running means
  static constexpr std::size_t pooled = 4 * channels;       ///< mean, maximum and two first moments over the places
  static constexpr std::size_t memory = 40;                 ///< units of the GRU
};

/// Options of kind `stream`.
struct StreamOptions {
  unsigned steps = 1600;  ///< of the training, 1 to 100 000

  friend bool operator==(const StreamOptions&, const StreamOptions&) = default;
};

template <class Fields>
void list_fields(Fields& fields, StreamOptions& o) {
  fields("steps", o.steps, 1, 100'000, {"steps", "With --kind stream: steps of the training"});
}

/// The parameters in a weights file: "grid" [4], the rectangle's left, top, right and bottom [px]; "cells" [24, 145] of the
/// logarithms of a place's counts and of their sum, "means" [24, 96], "place" [24, 24], each ".weight" with a ".bias" [24];
/// "gru.weight_ih" [120, 96], "gru.weight_hh" [120, 40], "gru.bias_ih" and "gru.bias_hh" [120], in libtorch's order of the gates:
/// reset, update, new; "out.weight" [3, 40] and "out.bias" [3].
std::vector<ParameterShape> stream_parameters();

}  // namespace tactile::model
