#include "tactile/experiments/trade/pareto_front.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tactile/core/random.hpp"

namespace tactile::trade {
namespace {

using Indexes = std::vector<std::size_t>;

TEST(ParetoFront, KeepsWhatNoOtherBeatsByX) {
  //                          beaten by 2   fast      best          slow, worse than 2
  const std::vector<TradePlace> places{{3, 5}, {1, 9}, {3, 4}, {8, 4.5}};
  EXPECT_EQ(pareto_front(places), (Indexes{1, 2}));
}

TEST(ParetoFront, OfAlikePlacesTheFirstStays) {
  const std::vector<TradePlace> places{{2, 2}, {2, 2}, {2, 3}, {3, 2}};
  EXPECT_EQ(pareto_front(places), (Indexes{0}));
}

TEST(ParetoFront, LeavesOutWhatIsNotFinite) {
  const std::vector<TradePlace> places{{NAN, 0}, {0, NAN}, {0, -INFINITY}, {4, 4}, {5, 3, NAN}};
  EXPECT_EQ(pareto_front(places), (Indexes{3}));
  EXPECT_TRUE(pareto_front({}).empty());
}

TEST(ParetoFront, AThirdThingKeepsAPlaceThatLosesInTheOthers) {
  const std::vector<TradePlace> places{{1, 1, 0.5}, {2, 2, 0.1}, {2, 2, 0.6}};
  EXPECT_EQ(pareto_front(places), (Indexes{0, 1}));
}

TEST(ParetoFront, IsWhatEveryPairComparedGives) {
  Random random(3);
  for (int round = 0; round < 20; ++round) {
    std::vector<TradePlace> places(60);
    for (TradePlace& place : places)
      place = {static_cast<double>(random.below(12)), static_cast<double>(random.below(12)),
               static_cast<double>(random.below(3))};
    std::set<std::size_t> expected;
    for (std::size_t i = 0; i < places.size(); ++i) {
      bool beaten = false;
      for (std::size_t k = 0; k < places.size(); ++k) {
        const auto& [x, y, z] = places[k];
        const bool no_greater = x <= places[i].x && y <= places[i].y && z <= places[i].z;
        const bool alike = x == places[i].x && y == places[i].y && z == places[i].z;
        beaten = beaten || (no_greater && (!alike || k < i));
      }
      if (!beaten) expected.insert(i);
    }
    const auto front = pareto_front(places);
    EXPECT_EQ(std::set<std::size_t>(front.begin(), front.end()), expected);
  }
}

}  // namespace
}  // namespace tactile::trade
