#pragma once

#include <cstddef>

namespace tactile::simulation {

/// ln of each value, which must be positive and normal, accurate to float.
void take_logs(float* values, std::size_t count);

inline float log_of(float value) {
  take_logs(&value, 1);
  return value;
}

}  // namespace tactile::simulation
