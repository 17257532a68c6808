#include "tactile/video/video_times.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::video {
namespace {

std::vector<VideoTime> read(const std::string& text) {
  const test::TemporaryFolder folder;
  write_whole(folder / "video.csv", text);
  return read_video_times(folder / "video.csv");
}

TEST(VideoTimes, ComeBackAsTheyWereWritten) {
  const std::vector<VideoTime> times{VideoTime{0us}, VideoTime{33'417us}, VideoTime{70'001us}};
  const test::TemporaryFolder folder;
  write_video_times(folder / "video.csv", times);
  EXPECT_EQ(read_text(folder / "video.csv"), "index,pts_us\n0,0\n1,33417\n2,70001\n");
  EXPECT_EQ(read_video_times(folder / "video.csv"), times);
}

TEST(VideoTimes, IgnoreFurtherColumnsAndWindowsLineEnds) {
  EXPECT_EQ(read("index,host_time_us,pts_us\r\n0,99,5\r\n1,98,6\r\n"), (std::vector<VideoTime>{VideoTime{5us}, VideoTime{6us}}));
}

TEST(VideoTimes, EndBeforeARowThatAKillHasCut) {
  const std::vector<VideoTime> whole{VideoTime{0us}, VideoTime{33'000us}};
  EXPECT_EQ(read("index,pts_us,host_time_us\n0,0,7\n1,33000,8\n2,660"), whole);
  EXPECT_EQ(read("index,pts_us,host_time_us\n0,0,7\n1,33000,8\n2,66000,9"), whole) << "9 of how many digits?";
  EXPECT_EQ(read("index,pts_us\n0,0\n1,33000\n"), whole);
  EXPECT_EQ(read("index,pts_us\n0,0\n1,33000\n" + std::string(100'000, '\0')), whole) << "as a power cut may leave it";
  EXPECT_TRUE(read("index,pts_us").empty());
}

TEST(VideoTimes, AreReadStrictly) {
  EXPECT_THROW(read(""), Error);
  EXPECT_THROW(read("index,pts_us\n0,0\n" + std::string(100'000, '1') + "\n2,5\n"), Error) << "a row without end";
  EXPECT_THROW(read(std::string("index,pts_us\n0,0\0x\n", 20)), Error) << "a zero byte ends no value";

  EXPECT_THROW(read("index\n0\n"), Error) << "no pts_us";
  EXPECT_THROW(read("index,pts_us\n0,0\n2,5\n"), Error) << "a skipped index";
  EXPECT_THROW(read("index,pts_us\n0,5\n1,5\n"), Error) << "a time twice";
  EXPECT_THROW(read("index,pts_us\n0,1.5\n"), Error) << "no whole number";
  EXPECT_THROW(read("index,pts_us\n0\n"), Error) << "a missing value";
  EXPECT_THROW(read_video_times("/nowhere/video.csv"), Error);
}

}  // namespace
}  // namespace tactile::video
