#pragma once

#include <cstddef>

namespace tactile {

/// So many multiply-adds of float32 in registers, with the widest vectors: what no engine can do without.
float multiply_adds(std::size_t count);

/// Reads all of them once.
float sum_of(const float* values, std::size_t count);

}  // namespace tactile
