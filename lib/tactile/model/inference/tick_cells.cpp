#include "tactile/model/inference/tick_cells.hpp"

#include <fmt/core.h>

namespace tactile::model {

std::string tick_cells(CameraTime t, const Probabilities& p, Touch verdict) {
  return fmt::format("{},{:.9g},{:.9g},{:.9g},{}", us_of(t), p[0], p[1], p[2], name_of(verdict));
}

}  // namespace tactile::model
