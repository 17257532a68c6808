#pragma once

#include <cstddef>

namespace tactile::bench {

/// Does `count` multiply-adds of float32 in registers, with the widest vectors: a lower limit of every engine.
float multiply_adds(std::size_t count);

/// The sum of all values, each read once.
float sum_of(const float* values, std::size_t count);

}  // namespace tactile::bench
