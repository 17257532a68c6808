#include "tactile/trade/pareto_front.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace tactile {

std::vector<std::size_t> pareto_front(std::span<const TradePlace> places) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (std::isfinite(places[i].x) && std::isfinite(places[i].y)) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(places[a].x, places[a].y, a) < std::tuple(places[b].x, places[b].y, b);
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order) {
    if (front.empty() || places[i].y < places[front.back()].y) front.push_back(i);
  }
  return front;
}

}  // namespace tactile
