#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tactile::trade {

/// Two or three figures of a setting, of which less is better.
struct TradePlace {
  double x = 0, y = 0, z = 0;
};

/// The places that no other beats, ordered by x. One place beats another if none of its figures is greater and one is smaller; of
/// equal places, the first beats the others. Places with a figure that is not finite are left out.
std::vector<std::size_t> pareto_front(std::span<const TradePlace> places);

}  // namespace tactile::trade
