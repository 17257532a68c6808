#pragma once

#include <cstdint>

#include "tactile/core/time.hpp"

namespace tactile::test {

inline HostTime host_time(std::int64_t us) { return HostTime{microseconds{us}}; }

}  // namespace tactile::test
