#include "tactile/experiments/trade/pareto_front.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace tactile::trade {

std::vector<std::size_t> pareto_front(std::span<const TradePlace> places) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (std::isfinite(places[i].x) && std::isfinite(places[i].y) && std::isfinite(places[i].z)) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(places[a].x, places[a].y, places[a].z, a) < std::tuple(places[b].x, places[b].y, places[b].z, b);
  });
  // In this order, only a place before it can beat it.
  std::vector<std::size_t> front;
  for (const std::size_t i : order) {
    const auto beats = [&](std::size_t other) { return places[other].y <= places[i].y && places[other].z <= places[i].z; };
    if (std::none_of(front.begin(), front.end(), beats)) front.push_back(i);
  }
  return front;
}

}  // namespace tactile::trade
