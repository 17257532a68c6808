#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>

namespace tactile::test {

/// How often the power is cut in each test: TACTILE_POWER_CUTS, for a longer run.
inline std::size_t power_cuts(std::size_t usual) {
  const char* wanted = std::getenv("TACTILE_POWER_CUTS");
  return wanted == nullptr ? usual : std::stoul(wanted);
}

/// What the dice begin with: TACTILE_POWER_SEED, for other moments.
inline std::uint64_t power_seed() {
  const char* wanted = std::getenv("TACTILE_POWER_SEED");
  return wanted == nullptr ? 1 : std::stoull(wanted);
}

}  // namespace tactile::test
