#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tactile {

/// Where a setting lies by two or three things of which less is better.
struct TradePlace {
  double x = 0, y = 0, z = 0;
};

/// The places that no other one beats, by x: none has all of them no greater and one smaller. Of alike ones the first. Places
/// that are not finite are not on it.
std::vector<std::size_t> pareto_front(std::span<const TradePlace> places);

}  // namespace tactile
