#include "tactile/pictures/recipe_sheet.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace tactile::pictures {
namespace {

TEST(RecipeSheet, ShowsTheEventsBeforeOnTheLeftAndAfterOnTheRight) {
  const std::vector<events::Event> events{{camera_time(50'000), 5, 6, 1},
                                          {camera_time(60'001), 10, 20, 1},
                                          {camera_time(99'999), 30, 40, 0},
                                          {camera_time(100'000), 50, 20, 1}};
  const cv::Mat sheet = recipe_sheet(events, {160, 120}, recipes::parse_recipe("shift:20"), camera_time(100'000));
  ASSERT_EQ(sheet.size(), cv::Size(2 * 160 + 8, 120 + 44));
  const auto colour_at = [&](int x, int y) { return sheet.at<cv::Vec3b>(44 + y, x); };
  const cv::Vec3b empty = colour_at(0, 0);
  EXPECT_GT(colour_at(10, 20)[0], colour_at(10, 20)[2]) << "ON is blue";
  EXPECT_LT(colour_at(30, 40)[0], colour_at(30, 40)[2]) << "OFF is red";
  EXPECT_EQ(colour_at(168 + 30, 20), colour_at(10, 20)) << "moved by 20 px";
  EXPECT_EQ(colour_at(168 + 50, 40), colour_at(30, 40));
  for (const cv::Point place : {cv::Point(5, 6), cv::Point(50, 20), cv::Point(168 + 10, 20), cv::Point(168 + 70, 20)})
    EXPECT_EQ(colour_at(place.x, place.y), empty) << "outside the 40 ms, or moved";
}

}  // namespace
}  // namespace tactile::pictures
