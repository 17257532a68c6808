#include "tactile/pictures/drawing.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

namespace tactile::pictures {
namespace {

cv::Mat numbered(int width, int height) {
  cv::Mat picture(height, width, CV_16UC1);
  for (int i = 0; i < width * height; ++i) picture.at<std::uint16_t>(i / width, i % width) = static_cast<std::uint16_t>(i);
  return picture;
}

TEST(FittedPicture, RepeatsPixelsAndKeepsTheLargestOfThoseItLeavesOut) {
  const cv::Mat picture = numbered(4, 3);
  const cv::Mat larger = fitted_picture(picture, {8, 9});
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 8; ++x) EXPECT_EQ(larger.at<std::uint16_t>(y, x), picture.at<std::uint16_t>(y / 3, x / 2));
  }
  const cv::Mat smaller = fitted_picture(picture, {2, 1});
  EXPECT_EQ(smaller.at<std::uint16_t>(0, 0), 9);
  EXPECT_EQ(smaller.at<std::uint16_t>(0, 1), 11);
  const cv::Mat both = fitted_picture(picture, {2, 6});  // narrower, and higher
  EXPECT_EQ(both.size(), cv::Size(2, 6));
  EXPECT_EQ(both.at<std::uint16_t>(5, 0), 9);
  EXPECT_EQ(both.at<std::uint16_t>(0, 1), 3);
}

TEST(FittedPicture, LosesNoPixelWhereTheSidesShareNoDivisor) {
  for (const auto& [from, to] : {std::pair(640, 256), {346, 276}, {7, 3}, {11, 10}, {5, 1}}) {
    for (int i = 0; i < from; ++i) {
      cv::Mat picture(2, from, CV_8UC1, cv::Scalar(0));
      picture.at<std::uint8_t>(1, i) = 200;
      EXPECT_EQ(cv::sum(fitted_picture(picture, {to, 1}))[0], 200) << from << " to " << to << ", pixel " << i;
    }
  }
}

TEST(ShownSize, IsAWholeMultipleOrMadeToFit) {
  EXPECT_EQ(shown_size({128, 96}, 256), cv::Size(256, 192));
  EXPECT_EQ(shown_size({69, 52}, 256), cv::Size(276, 208));
  EXPECT_EQ(shown_size({300, 10}, 256), cv::Size(300, 10));
  EXPECT_EQ(shown_size({640, 480}, 256), cv::Size(256, 192));
  EXPECT_EQ(shown_size({1, 1}, 256), cv::Size(256, 256));
  EXPECT_EQ(shown_size({5000, 1}, 256), cv::Size(256, 1));
}

TEST(FalseColours, GrowLighterWithTheValueUpToTheBrightest) {
  for (const ColourScale scale : {ColourScale::linear, ColourScale::root}) {
    cv::Mat grey;
    cv::cvtColor(false_colours(numbered(50, 1), 40, scale), grey, cv::COLOR_BGR2GRAY);
    EXPECT_LE(grey.at<std::uint8_t>(0, 0), 1) << "black";
    for (int i = 1; i <= 40; ++i) EXPECT_GT(grey.at<std::uint8_t>(0, i), grey.at<std::uint8_t>(0, i - 1)) << i;
    EXPECT_EQ(grey.at<std::uint8_t>(0, 49), grey.at<std::uint8_t>(0, 40));
  }
  const cv::Mat values(1, 1, CV_8UC1, cv::Scalar(25));
  EXPECT_EQ(cv::norm(false_colours(values, 100, ColourScale::root), false_colours(cv::Mat(values * 2), 100)), 0)
      << "the root of a quarter is a half";
}

TEST(TouchColours, DifferInLightnessAndHue) {
  const auto lightness = [](const cv::Scalar& bgr) { return 0.114 * bgr[0] + 0.587 * bgr[1] + 0.299 * bgr[2]; };
  const double press = lightness(touch_colour(Touch::press)), slip = lightness(touch_colour(Touch::slip)),
               none = lightness(touch_colour(Touch::none));
  EXPECT_GT(slip - press, 30);
  EXPECT_GT(none - slip, 30);
}

TEST(DrawText, StaysWithinItsWidth) {
  for (const std::string& text : {std::string("short"), std::string(200, 'W'), std::string("\xC2\xB5s and \xE2\x80\xA6")}) {
    cv::Mat picture(60, 400, CV_8UC3, paper);
    const int drawn = draw_text(picture, text, {20, 40}, 0.6, 200, ink);
    EXPECT_LE(drawn, 200);
    cv::Mat beyond = picture(cv::Rect(20 + drawn + 4, 0, 400 - 24 - drawn, 60)).clone();
    EXPECT_EQ(cv::norm(beyond, cv::Mat(beyond.size(), CV_8UC3, paper)), 0) << text;
    EXPECT_GT(cv::norm(picture, cv::Mat(picture.size(), CV_8UC3, paper)), 0) << text;
  }
  EXPECT_EQ(text_width("\xC2\xB5s", 0.6), text_width("?s", 0.6));
}

}  // namespace
}  // namespace tactile::pictures
