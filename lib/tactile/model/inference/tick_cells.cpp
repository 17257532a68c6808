#include "tactile/model/inference/tick_cells.hpp"

#include "tactile/core/csv_table.hpp"

namespace tactile::model {

std::array<std::string, 5> tick_cells(CameraTime t, const Probabilities& p, Touch verdict) {
  const auto number = [](auto value) { return csv_number(static_cast<double>(value)); };
  return {std::to_string(us_of(t)), number(p[0]), number(p[1]), number(p[2]), std::string(name_of(verdict))};
}

}  // namespace tactile::model
