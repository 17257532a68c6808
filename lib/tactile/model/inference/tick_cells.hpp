#pragma once

#include <array>
#include <string>

#include "tactile/core/time.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile::model {

/// The columns that every table of ticks begins with.
inline constexpr const char* tick_columns = "t_us,p_none,p_press,p_slip,verdict";

/// A tick's cells in `tick_columns`. The probabilities have the 9 digits that name a float32.
std::array<std::string, 5> tick_cells(CameraTime t, const Probabilities& p, Touch verdict);

}  // namespace tactile::model
