#include "tactile/splitting/cut_devices.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "support/host_time.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/video/film_part.hpp"
#include "tactile/video/video_times.hpp"
#include "tactile/video/video_writer.hpp"

namespace tactile::splitting {
namespace {
namespace fs = std::filesystem;

using test::host_time;

/// Robot time is 100 s ahead of camera time.
DeviceClock by_stamp() {
  DeviceClock clock;
  clock.relation = {.offset_us = -100'000'000, .drift_ppm = 0, .reference_us = 100'000'000};
  return clock;
}

TEST(DeviceClock, FollowsTheHostPairsPieceByPiece) {
  // The host's clock runs 10 ms per 10 s faster than the camera's.
  const DeviceClock clock{.arrivals = {{camera_time(0), host_time(1'000'000)}, {camera_time(10'000'000), host_time(11'010'000)}},
                          .how = {}};
  EXPECT_EQ(clock.device_us_at(camera_time(-500)), 999'500);
  EXPECT_EQ(clock.device_us_at(camera_time(1'000)), 1'001'000);
  EXPECT_EQ(clock.device_us_at(camera_time(9'000'000)), 10'010'000);
  EXPECT_EQ(clock.device_us_at(camera_time(12'000'000)), 13'010'000);
  EXPECT_EQ(clock.camera_at(10'010'000), camera_time(9'000'000));
}

/// Rows arrive in bursts of ten, 8 ms apart: the last one of a burst at once, the others when it does.
TEST(OffsetAround, IsThatOfTheRowThatArrivedFastest) {
  const DeviceClock clock{.arrivals = {{camera_time(0), host_time(1'000'000)}, {camera_time(10'000'000), host_time(11'000'000)}},
                          .how = {}};
  robot::RobotLog log;
  for (int i = 0; i < 1000; ++i) {
    robot::RobotState row{};
    row.t = RobotTime{microseconds{8'000 * i}};
    row.host_time = host_time(1'500'000 + 8'000 * (i / 10 * 10 + 9));
    log.states.push_back(row);
  }
  EXPECT_EQ(offset_around(clock, log, camera_time(4'000'000)).offset_us, 500'000);
  EXPECT_EQ(offset_around(by_stamp(), log, camera_time(4'000'000)).offset_us, -100'000'000);
}

TEST(SpansOf, GiveTheOuterPiecesAllThatLiesBeyond) {
  DeviceClock clock = by_stamp();
  clock.within = 200ms;
  const std::vector<CameraTime> cuts{camera_time(5'000'000), camera_time(9'000'000)};
  const auto spans = spans_of(clock, cuts, 1s);
  ASSERT_EQ(spans.size(), 3U);
  EXPECT_FALSE(spans[0].begin);
  EXPECT_EQ(spans[0].end, 106'200'000);
  EXPECT_EQ(spans[1].begin, 103'800'000);
  EXPECT_EQ(spans[1].end, 110'200'000);
  EXPECT_EQ(spans[2].begin, 107'800'000);
  EXPECT_FALSE(spans[2].end);
}

class CutDevices : public testing::Test {
 protected:
  test::TemporaryFolder folder;
};

TEST_F(CutDevices, CopyTheRowsOfEachPieceAsTheyAre) {
  write_whole(folder / "robot.csv",
              "timestamp; actual_q_0 ;note\n"
              "101.0; 0.50;a\n"
              "102.0;\"0.5\";b\n"
              "\n"
              "103.0;0.5;c\n"
              "104.0;0.5");
  const std::vector<fs::path> logs{folder / "1.csv", folder / "2.csv"};
  const std::vector<CameraTime> cuts{camera_time(2'500'000)};
  SplitSource source;
  source.robot = folder / "robot.csv";
  const auto rows = cut_robot_log(source, by_stamp(), spans_of(by_stamp(), cuts, 600ms), logs);
  EXPECT_EQ(rows, (std::vector<std::uint64_t>{3, 2}));
  // 102 is in both; the row that is cut off, and the lost connection, follow the row before them.
  EXPECT_EQ(read_text(logs[0]), "timestamp; actual_q_0 ;note\n101.0; 0.50;a\n102.0;\"0.5\";b\n\n103.0;0.5;c\n104.0;0.5");
  EXPECT_EQ(read_text(logs[1]), "timestamp; actual_q_0 ;note\n102.0;\"0.5\";b\n\n103.0;0.5;c\n104.0;0.5");
}

TEST_F(CutDevices, PlaceRowsByTheirHostTimes) {
  write_whole(folder / "robot.csv", "timestamp,host_time_us\n7.0,1000000\n0.1,2000000\n0.2,3000000\n");  // the clock restarts
  const DeviceClock clock{.arrivals = {{camera_time(0), host_time(0)}}, .how = {}};
  const std::vector<fs::path> logs{folder / "1.csv", folder / "2.csv"};
  const std::vector<CameraTime> cuts{camera_time(1'500'000)};
  SplitSource source;
  source.robot = folder / "robot.csv";
  EXPECT_EQ(cut_robot_log(source, clock, spans_of(clock, cuts, 0s), logs), (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(read_text(logs[1]), "timestamp,host_time_us\n0.1,2000000\n0.2,3000000\n");
}

TEST_F(CutDevices, GiveALogWithoutHeaderTheNamesOfItsColumns) {
  write_whole(folder / "robot.csv", "101.0 7 0.5\n102.0 7 0.6\n103.0 7 0.7\n");
  SplitSource source;
  source.robot = folder / "robot.csv";
  source.robot_columns = "timestamp,-,actual_q_0";
  const std::vector<fs::path> logs{folder / "1.csv", folder / "2.csv"};
  const std::vector<CameraTime> cuts{camera_time(1'500'000)};
  EXPECT_EQ(cut_robot_log(source, by_stamp(), spans_of(by_stamp(), cuts, 0s), logs), (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(read_text(logs[1]), "timestamp unused_2 actual_q_0\n102.0 7 0.6\n103.0 7 0.7\n");
  EXPECT_EQ(cut_robot_log(source, {}, std::vector<DeviceSpan>(2), logs), (std::vector<std::uint64_t>{3, 3}));
  EXPECT_EQ(read_text(logs[0]), read_text(logs[1]));
}

/// Frames of 100 ms, a key frame each second.
void write_film(const fs::path& file, int frames) {
  video::VideoWriter writer(file, {.width = 64, .height = 48, .frames_per_fragment = 10});
  for (int i = 0; i < frames; ++i) {
    cv::Mat frame(48, 64, CV_8UC1, cv::Scalar(40));
    frame(cv::Rect(i, 20, 8, 8)).setTo(200);
    writer.write(frame, VideoTime{microseconds{100'000 * i}});
  }
  writer.close();
}

TEST_F(CutDevices, KeepTheFilmsOwnClockInAllPieces) {
  write_film(folder / "film.mp4", 40);
  std::string times = "index,pts_us,host_time_us\n";
  for (int i = 0; i < 40; ++i) times += fmt::format("{},{},{}\n", i, 5'000'000 + 100'000 * i, 900'000 + 100'000 * i);
  write_whole(folder / "film.csv", times);
  SplitSource source;
  source.video = folder / "film.mp4";
  source.video_times = folder / "film.csv";
  const DeviceClock clock{.arrivals = {{camera_time(0), host_time(0)}}, .how = {}};
  const std::vector<CameraTime> cuts{camera_time(2'400'000), camera_time(60'000'000)};
  const std::vector<FilmFiles> files{
      {folder / "1.mp4", folder / "1.csv"}, {folder / "2.mp4", folder / "2.csv"}, {folder / "3.mp4", folder / "3.csv"}};
  const auto frames = cut_film(source, clock, spans_of(clock, cuts, 0s), files);
  // The first frame is at 0.9 s, so the cut is before frame 15: the second piece begins with the key frame 10.
  EXPECT_EQ(frames, (std::vector<std::uint64_t>{15, 30, 0}));
  const auto second = video::read_video_times(files[1].times);
  ASSERT_EQ(second.size(), 30U);
  EXPECT_EQ(second.front(), VideoTime{6'000'000us});
  EXPECT_NE(read_text(files[1].times).find("\n0,6000000,1900000\n1,6100000,2000000\n"), std::string::npos);
  EXPECT_EQ(video::film_frames(files[1].film).times_us.size(), 30U);
  EXPECT_FALSE(fs::exists(files[2].film));
}

TEST_F(CutDevices, WriteTimesForAFilmThatHasNone) {
  write_film(folder / "film.mp4", 30);
  SplitSource source;
  source.video = folder / "film.mp4";
  DeviceClock clock;  // film and camera begin together
  const std::vector<CameraTime> cuts{camera_time(1'950'000)};
  const std::vector<FilmFiles> files{{folder / "1.mp4", folder / "1.csv"}, {folder / "2.mp4", folder / "2.csv"}};
  EXPECT_EQ(cut_film(source, clock, spans_of(clock, cuts, 0s), files), (std::vector<std::uint64_t>{20, 10}));
  EXPECT_EQ(video::read_video_times(files[1].times).front(), VideoTime{2'000'000us});
}

}  // namespace
}  // namespace tactile::splitting
