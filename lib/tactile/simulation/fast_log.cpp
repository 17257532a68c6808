#include "tactile/simulation/fast_log.hpp"

#include <bit>
#include <cstdint>
#include <numbers>

namespace tactile::simulation {

// x = 2^k m with m from 1/sqrt(2) to sqrt(2), and ln m = 2 (s + s^3/3 + s^5/5 + s^7/7 + s^9/9) with s = (m - 1) / (m + 1). The
// simple steps allow the compiler to vectorise.
void take_logs(float* values, std::size_t count) {
  constexpr std::uint32_t root_half = 0x3f3504f3;  // 1/sqrt(2)
  for (std::size_t i = 0; i < count; ++i) {
    const auto bits = std::bit_cast<std::uint32_t>(values[i]);
    const std::int32_t k = static_cast<std::int32_t>(bits - root_half) >> 23;
    const auto m = std::bit_cast<float>(bits - (static_cast<std::uint32_t>(k) << 23));
    const float s = (m - 1.0F) / (m + 1.0F), q = s * s;
    const float series = q * (1.0F / 3 + q * (1.0F / 5 + q * (1.0F / 7 + q * (1.0F / 9))));
    values[i] = static_cast<float>(k) * std::numbers::ln2_v<float> + (2.0F * s + 2.0F * s * series);
  }
}

}  // namespace tactile::simulation
