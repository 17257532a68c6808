#include "tactile/events/pixel_mask.hpp"

#include <gtest/gtest.h>

#include "events/aedat4_bytes.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::events {
namespace {

MaskPixels read(const std::string& text) {
  const test::TemporaryFolder folder;
  write_whole(folder / "mask.csv", text);
  return read_mask(folder / "mask.csv");
}

TEST(PixelMask, LeavesOutItsPixelsAndKeepsTheOrderOfTheOthers) {
  const PixelMask mask({10, 5}, {{3, 2}, {9, 4}});
  const std::vector<Event> events{test::event(1, 3, 2, 1), test::event(2, 2, 3, 1), test::event(3, 9, 4, 0),
                                  test::event(4, 0, 0, 1)};
  std::vector<Event> kept;
  const auto left = mask.without(events, kept);
  ASSERT_EQ(left.size(), 2U);
  EXPECT_EQ(left[0], events[1]);
  EXPECT_EQ(left[1], events[3]);
}

TEST(PixelMask, WithoutPixelsCopiesNothing) {
  const std::vector<Event> events{test::event(1, 3, 2, 1)};
  std::vector<Event> kept;
  EXPECT_EQ(PixelMask().without(events, kept).data(), events.data());
  EXPECT_FALSE(PixelMask().covers(events[0]));
}

TEST(PixelMask, DoesNotCoverWhatLiesOutsideTheSensor) {
  const PixelMask mask({4, 4}, {{3, 3}});
  EXPECT_FALSE(mask.covers(test::event(1, 4, 3, 1)));
  EXPECT_FALSE(mask.covers(test::event(1, -1, 3, 1)));
}

TEST(PixelMask, RefusesAPixelOutsideTheSensor) {
  EXPECT_EQ(test::error_of([] {
              PixelMask({4, 4}, {{1, 4}}, "mask.csv");
            }),
            "mask.csv: pixel (1, 4) lies outside the sensor; expected one of 4x4 pixels");
}

TEST(ReadMask, TakesAnyOrderOfColumnsAndRowsAndEachPixelOnce) {
  const MaskPixels expected{{5, 1}, {2, 3}};
  EXPECT_EQ(read("x,y\n2,3\n5,1\n"), expected);
  EXPECT_EQ(read("kind,y,x\r\nhot,1,5\r\nstuck,3,2\r\nhot,1,5\r\n"), expected);
  EXPECT_TRUE(read("x,y,kind,rate_hz\n").empty());
}

TEST(ReadMask, RefusesOtherTables) {
  EXPECT_NE(test::error_of([] { read("a,b\n1,2\n"); }).find("mask.csv: has no columns x and y; expected a mask"),
            std::string::npos);
  EXPECT_NE(test::error_of([] { read("x,y\n1\n"); }).find("mask.csv, line 2: '1' is no pixel; expected x,y from 0 to 32767"),
            std::string::npos);
  EXPECT_NE(test::error_of([] { read("x,y\n1,2.5\n"); }).find("line 2"), std::string::npos);
  EXPECT_NE(test::error_of([] { read("x,y\n1,2\n-1,2\n"); }).find("line 3"), std::string::npos);
  EXPECT_THROW(read_mask("no-such-mask.csv"), Error);
}

}  // namespace
}  // namespace tactile::events
