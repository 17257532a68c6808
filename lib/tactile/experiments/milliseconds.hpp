#pragma once

#include <fmt/core.h>

#include <string>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/time.hpp"

namespace tactile::experiments {

/// "2", "2.5"
inline std::string ms_text(microseconds us) { return fmt::format("{}", in_ms(us)); }

}  // namespace tactile::experiments
