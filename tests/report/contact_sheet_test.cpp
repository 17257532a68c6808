#include "tactile/report/contact_sheet.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"

namespace tactile {
namespace {

SheetTile tile_of(int width, int height, std::uint8_t value = 100) {
  return {.heatmap = cv::Mat(height, width, CV_8UC1, cv::Scalar(value)),
          .caption = "1.0 ms",
          .second_caption = "2 events",
          .touch = {}};
}

/// Whether a frame of that many pixels along the edge is blank: nothing was drawn into it, so nothing is clipped by it.
bool edge_is_blank(const cv::Mat& sheet, int wide) {
  cv::Mat inked;
  cv::inRange(sheet, cv::Scalar(255, 255, 255), cv::Scalar(255, 255, 255), inked);
  inked = 255 - inked;
  inked(cv::Rect(wide, wide, sheet.cols - 2 * wide, sheet.rows - 2 * wide)).setTo(0);
  return cv::countNonZero(inked) == 0;
}

TEST(ContactSheet, ShowsEveryHeatmapPixelEnlargedAndEqualOnesAlike) {
  SheetTile tile = tile_of(4, 3, 0);
  tile.heatmap.at<std::uint8_t>(1, 2) = 255;
  const cv::Mat sheet = contact_sheet({{.title = "", .tiles = {tile}}}, {.header = {}, .scale = 10});
  cv::Mat bright;  // the map's brightest colour, found nowhere else on the sheet
  cv::inRange(sheet, cv::Scalar(164, 255, 252), cv::Scalar(164, 255, 252), bright);
  EXPECT_EQ(cv::countNonZero(bright), 100);
}

TEST(ContactSheet, ClipsNothingWhateverTheTextAndTheSize) {
  const std::string long_text(400, 'W');
  for (const auto& [width, height] : {std::pair(128, 96), {69, 52}, {64, 48}, {32, 24}, {1, 1}, {400, 20}}) {
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

TEST(ContactSheet, FramesPressAndSlipInColoursOfTheirOwn) {
  SheetTile none = tile_of(10, 10), press = none, slip = none;
  none.touch = Touch::none;
  press.touch = Touch::press;
  slip.touch = Touch::slip;
  const auto sheet_of = [](const SheetTile& tile) { return contact_sheet({{.title = "", .tiles = {tile}}}); };
  EXPECT_GT(cv::norm(sheet_of(none), sheet_of(press)), 0);
  EXPECT_GT(cv::norm(sheet_of(slip), sheet_of(press)), 0);
  EXPECT_GT(cv::norm(sheet_of(slip), sheet_of(none)), 0);
}

TEST(ContactSheet, StretchesItsColoursToTheBrightestValue) {
  const auto middle_of = [](std::uint8_t value, int brightest) {
    const cv::Mat sheet =
        contact_sheet({{.title = "", .tiles = {tile_of(10, 10, value)}}}, {.header = {}, .brightest = brightest});
    return sheet.at<cv::Vec3b>(80, 80);
  };
  EXPECT_EQ(middle_of(50, 50), middle_of(255, 255));
  EXPECT_EQ(middle_of(200, 50), middle_of(255, 255));
  EXPECT_NE(middle_of(50, 255), middle_of(255, 255));
}

TEST(ContactSheet, RefusesNoTilesTilesOfSeveralSizesAndOptionsOutOfRange) {
  EXPECT_THROW(contact_sheet({}), Error);
  EXPECT_THROW(contact_sheet({{.title = "empty", .tiles = {}}}), Error);
  EXPECT_THROW(contact_sheet({{.title = "", .tiles = {tile_of(4, 3), tile_of(3, 4)}}}), Error);
  SheetTile colour = tile_of(4, 3);
  colour.heatmap = cv::Mat(3, 4, CV_8UC3);
  EXPECT_THROW(contact_sheet({{.title = "", .tiles = {colour}}}), Error);
  EXPECT_THROW(contact_sheet({{.title = "", .tiles = {tile_of(4, 3)}}}, {.header = {}, .columns = 0}), Error);
  EXPECT_THROW(contact_sheet({{.title = "", .tiles = {tile_of(4, 3)}}}, {.header = {}, .brightest = 0}), Error);
}

TEST(WritePng, IsReadBackPixelByPixel) {
  const test::TemporaryFolder folder;
  const cv::Mat sheet = contact_sheet({{.title = "group", .tiles = {tile_of(5, 5)}}}, {.header = {"header"}});
  write_png(folder / "below/sheet.png", sheet);
  EXPECT_EQ(cv::norm(cv::imread((folder / "below/sheet.png").string(), cv::IMREAD_UNCHANGED), sheet, cv::NORM_L1), 0);
  EXPECT_THROW(write_png("/proc/nowhere/sheet.png", sheet), Error);
}

}  // namespace
}  // namespace tactile
