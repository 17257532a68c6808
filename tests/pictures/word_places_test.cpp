#include "tactile/pictures/word_places.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tactile::pictures {
namespace {

constexpr PlotBox panel{.left = 0, .top = 0, .right = 400, .bottom = 300};

TEST(WordPlaces, AreNextToAMarkWithoutCoveringIt) {
  WordPlaces places(panel);
  places.take(194, 144, 206, 156);
  const WordPlaces::Place place = places.near(200, 150, 40);
  EXPECT_TRUE(place.is_plain());
  const bool is_aside = std::abs(place.x - 200) >= 26, is_above_or_below = std::abs(place.y - 150) >= 14;
  EXPECT_TRUE(is_aside || is_above_or_below) << place.x << ", " << place.y;
  EXPECT_LT(std::hypot(place.x - 200, place.y - 150), 50);
}

TEST(WordPlaces, StayWithinThePanel) {
  const WordPlaces places(panel);
  for (const auto& [x, y] : {std::pair(0.0, 0.0), std::pair(400.0, 300.0), std::pair(0.0, 300.0), std::pair(400.0, 150.0)}) {
    const WordPlaces::Place place = places.near(x, y, 60);
    EXPECT_TRUE(place.is_free);
    EXPECT_GE(place.x - 30, 0);
    EXPECT_LE(place.x + 30, 400);
    EXPECT_GE(place.y - 8, 0);
    EXPECT_LE(place.y + 8, 300);
  }
}

TEST(WordPlaces, MoveOffWhereItIsCrowdedAndReportThatALineIsWanted) {
  WordPlaces places(panel);
  places.take(160, 120, 240, 180);
  const WordPlaces::Place place = places.near(200, 150, 20);
  EXPECT_TRUE(place.is_free);
  EXPECT_FALSE(place.is_beside);
}

TEST(WordPlaces, OfManyWordsNoneStandOnOthersWhileThereIsRoom) {
  WordPlaces places(panel);
  std::vector<WordPlaces::Place> all;
  for (int i = 0; i < 20; ++i) {
    all.push_back(places.near(200 + i % 3, 150 + i % 2, 20));
    EXPECT_FALSE(all.back().covers_words) << i;
    places.take(all.back());
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k)
      EXPECT_TRUE(std::abs(all[i].x - all[k].x) >= 20 || std::abs(all[i].y - all[k].y) >= 16) << i << " and " << k;
  }
}

TEST(WordPlaces, PutWordsOnABarRatherThanOnWords) {
  WordPlaces places({.left = 0, .top = 0, .right = 60, .bottom = 40});
  for (const double x : {15.0, 45.0}) places.take({.x = x, .y = 10, .width = 30});
  places.take(0, 20, 60, 40);
  const WordPlaces::Place place = places.near(30, 20, 10);
  EXPECT_FALSE(place.is_free);
  EXPECT_FALSE(place.covers_words);
  EXPECT_GE(place.y - 8, 18);
}

TEST(WordPlaces, OfNoPlaceAreNeitherFreeNorNextToTheMark) {
  const WordPlaces places(panel);
  for (const WordPlaces::Place& place : {places.near(NAN, 10, 10), places.near(10, INFINITY, 10), places.near(200, 150, 500)})
    EXPECT_FALSE(place.is_free || place.is_beside);
}

}  // namespace
}  // namespace tactile::pictures
