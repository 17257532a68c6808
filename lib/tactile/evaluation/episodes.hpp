#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/touch.hpp"

namespace tactile::evaluation {

/// A maximal row of ticks with one verdict other than none.
struct Episode {
  Touch touch = Touch::none;
  std::int64_t first = 0;  ///< tick index
  std::int64_t last = 0;   ///< tick index, in the episode

  friend bool operator==(const Episode&, const Episode&) = default;
};

/// Every episode of a run's verdicts, one verdict for each tick, in order.
std::vector<Episode> episodes_in(std::span<const Touch> verdicts);

}  // namespace tactile::evaluation
