#pragma once

#include <limits>

namespace tactile {

inline constexpr double infinite = std::numeric_limits<double>::infinity();

}  // namespace tactile
