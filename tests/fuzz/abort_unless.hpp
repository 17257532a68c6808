#pragma once

#include <cstdlib>

namespace tactile::test {

/// Aborts if a condition is false, so that the fuzzer reports the input.
inline void abort_unless(bool condition) {
  if (!condition) std::abort();
}

}  // namespace tactile::test
