#include "tactile/pictures/contact_sheet.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/pictures/drawing.hpp"

namespace tactile::pictures {
namespace {

SheetTile tile_of(int width, int height, int value = 100, std::optional<Touch> touch = {}) {
  return {.counts = cv::Mat(height, width, CV_16UC1, cv::Scalar(value)),
          .denoised = cv::Mat(height, width, CV_8UC1, cv::Scalar(value)),
          .heatmap = cv::Mat(height, width, CV_8UC1, cv::Scalar(value)),
          .caption = "1.0 ms",
          .second_caption = "2 events",
          .touch = touch};
}

cv::Mat mask_of(const cv::Mat& picture, const cv::Scalar& colour) {
  cv::Mat found;
  cv::inRange(picture, colour, colour, found);
  return found;
}

/// How many frames of this colour: an area of it that hangs together and is as large as a frame.
int number_of_frames(const cv::Mat& sheet, const cv::Scalar& colour) {
  cv::Mat labels, numbers, middles;
  const int count = cv::connectedComponentsWithStats(mask_of(sheet, colour), labels, numbers, middles);
  int frames = 0;
  for (int i = 1; i < count; ++i) frames += numbers.at<int>(i, cv::CC_STAT_AREA) > 1000 ? 1 : 0;
  return frames;
}

/// Whether a frame of that many pixels along the edge is blank: nothing was drawn into it, so nothing is clipped by it.
bool edge_is_blank(const cv::Mat& sheet, int wide) {
  cv::Mat inked = 255 - mask_of(sheet, {255, 255, 255});
  inked(cv::Rect(wide, wide, sheet.cols - 2 * wide, sheet.rows - 2 * wide)).setTo(0);
  return cv::countNonZero(inked) == 0;
}

TEST(ContactSheet, FramesThreePicturesOfEveryMomentInTheColourOfItsLabel) {
  std::vector<SheetTile> press(4, tile_of(128, 96, 0, Touch::press)), slip(2, tile_of(128, 96, 0, Touch::slip));
  press.front().touch = Touch::none;
  const cv::Mat sheet = contact_sheet({{.title = "press", .tiles = press}, {.title = "slip", .tiles = slip}}, {.columns = 3});
  EXPECT_EQ(number_of_frames(sheet, touch_colour(Touch::press)), 3 * 3);
  EXPECT_EQ(number_of_frames(sheet, touch_colour(Touch::slip)), 2 * 3);
  EXPECT_EQ(number_of_frames(sheet, touch_colour(Touch::none)), 1 * 3);
}

TEST(ContactSheet, ShowsEachOfTheThreePicturesByItsOwnScale) {
  SheetTile tile = tile_of(128, 96, 0);
  tile.counts.at<std::uint16_t>(10, 20) = 7;
  tile.denoised.at<std::uint8_t>(30, 40) = 255;
  tile.heatmap.at<std::uint8_t>(50, 60) = 90;
  const auto bright_pixels = [&](const Brightness& brightness) {
    const cv::Mat sheet = contact_sheet({{.title = "", .tiles = {tile}}}, {.brightness = brightness});
    const cv::Mat dark = contact_sheet({{.title = "", .tiles = {tile_of(128, 96, 0)}}}, {.brightness = brightness});
    const cv::Scalar brightest(164, 255, 252);  // of which the scales have some too
    return cv::countNonZero(mask_of(sheet, brightest)) - cv::countNonZero(mask_of(dark, brightest));
  };
  constexpr int one = 4;  // a pixel, shown twice as large
  EXPECT_EQ(bright_pixels({.counts = 7, .heatmap = 90}), 3 * one);
  EXPECT_EQ(bright_pixels({.counts = 8, .heatmap = 90}), 2 * one);
  EXPECT_EQ(bright_pixels({.counts = 3, .heatmap = 91}), 2 * one) << "what lies above the scale is as bright as its end";
  EXPECT_EQ(bright_pixels({.counts = 8, .heatmap = 91}), one);
}

TEST(ContactSheet, ClipsNothingWhateverTheTextAndTheSize) {
  const std::string long_text(400, 'W');
  for (const auto& [width, height] :
       {std::pair(128, 96), {69, 52}, {64, 48}, {32, 24}, {1, 1}, {400, 20}, {3, 300}, {640, 480}}) {
    for (const std::size_t count : {1U, 3U, 6U, 25U}) {
      SheetTile tile = tile_of(width, height);
      tile.caption = long_text;
      tile.second_caption = long_text;
      const std::vector<SheetGroup> groups{{.title = long_text, .tiles = std::vector(count, tile)},
                                           {.title = "second", .tiles = {tile}}};
      const cv::Mat sheet = contact_sheet(groups, {.header = {long_text, "second line", "µ is no ASCII"}});
      EXPECT_EQ(sheet.type(), CV_8UC3);
      EXPECT_TRUE(edge_is_blank(sheet, 12)) << width << 'x' << height << ", " << count;
    }
  }
}

TEST(ContactSheet, HasRoomForABanner) {
  cv::Rect place;
  const std::vector<SheetGroup> groups{{.title = "", .tiles = {tile_of(8, 6)}}};
  SheetOptions options{.header = {"title"}};
  const int height = contact_sheet(groups, options).rows;
  options.banner = {.height = 70, .draw = [&](cv::Mat& sheet, const cv::Rect& given) {
                      place = given;
                      sheet(given).setTo(cv::Scalar(1, 2, 3));
                    }};
  const cv::Mat sheet = contact_sheet(groups, options);
  EXPECT_GE(sheet.rows, height + 70);
  EXPECT_EQ(cv::countNonZero(mask_of(sheet, {1, 2, 3})), 70 * place.width) << "nothing is drawn over it";
}

TEST(ContactSheet, KeepsOfAMomentWhatIsShown) {
  Moment moment;
  moment.counts = cv::Mat(480, 640, CV_16UC1, cv::Scalar(0));
  moment.counts.at<std::uint16_t>(479, 639) = 300;
  moment.denoised = cv::Mat(480, 640, CV_8UC1, cv::Scalar(0));
  moment.heatmap = cv::Mat(96, 128, CV_8UC1, cv::Scalar(5));
  const SheetTile tile = sheet_tile(moment);
  EXPECT_EQ(tile.counts.size(), cv::Size(256, 192));
  EXPECT_EQ(tile.counts.at<std::uint16_t>(191, 255), 300) << "a single pixel's events are still seen";
  EXPECT_EQ(cv::sum(tile.counts)[0], 300);
  EXPECT_EQ(tile.heatmap.size(), cv::Size(128, 96));
  moment.heatmap.setTo(0);
  EXPECT_EQ(tile.heatmap.at<std::uint8_t>(0, 0), 5) << "the moment's pictures change, the tile's do not";
}

TEST(ContactSheet, RefusesNoTilesTilesOfSeveralSizesAndOptionsOutOfRange) {
  using test::error_of;
  EXPECT_NE(error_of([] { contact_sheet({}); }).find("no tile"), std::string::npos);
  EXPECT_THROW(contact_sheet({{.title = "empty", .tiles = {}}}), Error);
  EXPECT_NE(error_of([] {
              contact_sheet({{.title = "", .tiles = {tile_of(4, 3), tile_of(3, 4)}}});
            }).find("differ in size"),
            std::string::npos);
  SheetTile lacking = tile_of(4, 3);
  lacking.denoised = cv::Mat();
  EXPECT_NE(error_of([&] { contact_sheet({{.title = "", .tiles = {lacking}}}); }).find("lacks a picture"), std::string::npos);
  SheetTile colour = tile_of(4, 3);
  colour.heatmap = cv::Mat(3, 4, CV_8UC3);
  EXPECT_THROW(contact_sheet({{.title = "", .tiles = {colour}}}), Error);
  const std::vector<SheetGroup> one{{.title = "", .tiles = {tile_of(4, 3)}}};
  EXPECT_THROW(contact_sheet(one, {.columns = 0}), Error);
  EXPECT_THROW(contact_sheet(one, {.brightness = {.counts = 0, .heatmap = 1}}), Error);
  EXPECT_THROW(contact_sheet(one, {.brightness = {.counts = 1, .heatmap = 256}}), Error);
  const std::vector<SheetGroup> many{{.title = "", .tiles = std::vector(600, tile_of(128, 96))}};
  EXPECT_NE(error_of([&] { contact_sheet(many, {.columns = 1}); }).find("expected fewer tiles"), std::string::npos);
}

TEST(WritePng, IsReadBackPixelByPixel) {
  const test::TemporaryFolder folder;
  const cv::Mat sheet = contact_sheet({{.title = "group", .tiles = {tile_of(5, 5)}}}, {.header = {"header"}});
  write_png(folder / "below/sheet.png", sheet);
  EXPECT_EQ(cv::norm(cv::imread((folder / "below/sheet.png").string(), cv::IMREAD_UNCHANGED), sheet, cv::NORM_L1), 0);
  EXPECT_THROW(write_png("/proc/nowhere/sheet.png", sheet), Error);
}

}  // namespace
}  // namespace tactile::pictures
