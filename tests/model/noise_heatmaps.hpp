#pragma once

#include <cstdint>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/events/event.hpp"

namespace tactile::test {

struct NoiseHeatmaps {
  events::SensorSize size;
  std::vector<std::uint8_t> heatmaps;  ///< [truth, height, width]
  std::vector<Touch> truth;            ///< none, press, slip in turn
};

/// Heatmaps of random cells, one in five of them active, that have nothing to do with their touch: they can only be learned by
/// heart.
inline NoiseHeatmaps noise_heatmaps(std::size_t count, events::SensorSize size, std::uint64_t seed) {
  Random random(seed);
  NoiseHeatmaps noise{size, {}, {}};
  const std::size_t cells = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  noise.heatmaps.resize(count * cells);
  for (std::uint8_t& cell : noise.heatmaps)
    cell = random.below(5) == 0 ? static_cast<std::uint8_t>(random.below(256)) : std::uint8_t{0};
  for (std::size_t i = 0; i < count; ++i) noise.truth.push_back(all_touches[i % touch_count]);
  return noise;
}

}  // namespace tactile::test
