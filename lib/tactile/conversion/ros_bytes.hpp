#pragma once

#include <cstddef>
#include <cstring>
#include <span>

namespace tactile::conversion {

using Bytes = std::span<const std::byte>;

/// The number that is stored from `offset` on, little-endian.
template <class T>
T number_at(Bytes bytes, std::size_t offset = 0) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace tactile::conversion
