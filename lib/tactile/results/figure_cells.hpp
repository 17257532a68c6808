#pragma once

#include <array>
#include <string>

#include "tactile/core/csv_table.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::results {

/// The value, `low` and `high` of a figure as cells of a table; what is unknown is empty.
inline std::array<std::string, 3> figure_cells(const Figure& figure, int digits = 9) {
  return {csv_number(figure.value, digits), csv_number(figure.low, digits), csv_number(figure.high, digits)};
}

}  // namespace tactile::results
