#include "tactile/video/film_part.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/video/film_reader.hpp"
#include "tactile/video/video_writer.hpp"

namespace tactile::video {
namespace {

/// Frame i is at i * 33 ms + 1 ms for every third, with a square whose column is i.
constexpr std::int64_t time_of(int i) { return 33'000 * i + (i % 3 == 0 ? 0 : 1'000); }

void write_short_film(const std::filesystem::path& file, int frames) {
  VideoWriter writer(file, {.width = 128, .height = 64, .frames_per_fragment = 10});
  for (int i = 0; i < frames; ++i) {
    cv::Mat frame(64, 128, CV_8UC1, cv::Scalar(40));
    frame(cv::Rect(i, 20, 16, 16)).setTo(200);
    writer.write(frame, VideoTime{microseconds{time_of(i)}});
  }
  writer.close();
}

std::vector<cv::Mat> pictures_of(const std::filesystem::path& film) {
  FilmReader reader(film);
  std::vector<cv::Mat> pictures;
  while (reader.next()) {
    cv::Mat grey;
    EXPECT_TRUE(reader.grey(128, grey));
    pictures.push_back(grey.clone());
  }
  return pictures;
}

class FilmPartTest : public testing::Test {
 protected:
  FilmPartTest() { write_short_film(film, 45); }

  test::TemporaryFolder folder;
  std::filesystem::path film = folder / "film.mp4", part = folder / "part.mp4";
};

TEST_F(FilmPartTest, ListsTheFramesWithTheirTimes) {
  const FilmFrames frames = film_frames(film);
  ASSERT_EQ(frames.times_us.size(), 45U);
  EXPECT_TRUE(frames.is_in_order);
  for (int i = 0; i < 45; ++i) EXPECT_EQ(frames.times_us[static_cast<std::size_t>(i)], time_of(i));
  EXPECT_EQ(frames.key_before(9), 0U);
  EXPECT_EQ(frames.key_before(10), 10U);
  EXPECT_EQ(frames.key_before(29), 20U);
}

TEST_F(FilmPartTest, HasTheSamePicturesAndTimesFromTheKeyFrameOn) {
  const FilmFrames frames = film_frames(film);
  const FilmPart copied = copy_film_part(film, frames, {23, 37}, part);
  EXPECT_EQ(copied.begin, 20U);
  EXPECT_EQ(copied.end, 37U);
  const std::vector<cv::Mat> whole = pictures_of(film), some = pictures_of(part);
  ASSERT_EQ(some.size(), 17U);
  for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(cv::norm(some[i], whole[20 + i], cv::NORM_INF), 0.0) << i;
  const FilmFrames of_part = film_frames(part);
  for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(of_part.times_us[i], time_of(20 + static_cast<int>(i)) - time_of(20));
}

TEST_F(FilmPartTest, EndsAFilmWithReorderedFramesBeforeAKeyFrame) {
  const std::filesystem::path reordered = folder / "reordered.mp4";
  cv::VideoWriter writer(reordered.string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('a', 'v', 'c', '1'), 30.0, {128, 64});
  if (!writer.isOpened()) GTEST_SKIP() << "NOT TESTED: OpenCV has no encoder for H.264";
  for (int i = 0; i < 600; ++i) {
    cv::Mat frame(64, 128, CV_8UC3, cv::Scalar::all(40));
    frame(cv::Rect(i % 100, 20, 16, 16)).setTo(200);
    writer.write(frame);
  }
  writer.release();
  const FilmFrames frames = film_frames(reordered);
  ASSERT_FALSE(frames.is_in_order);
  const FilmPart copied = copy_film_part(reordered, frames, {300, 310}, part);
  EXPECT_GT(copied.begin, 0U);
  EXPECT_TRUE(frames.is_key[copied.begin]);
  ASSERT_LT(copied.end, 600U);
  EXPECT_TRUE(frames.is_key[copied.end]);
  const std::vector<cv::Mat> whole = pictures_of(reordered), some = pictures_of(part);
  ASSERT_EQ(some.size(), copied.end - copied.begin);
  for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(cv::norm(some[i], whole[copied.begin + i], cv::NORM_INF), 0.0) << i;
}

TEST_F(FilmPartTest, RefusesAPartWithoutFrames) {
  const FilmFrames frames = film_frames(film);
  EXPECT_NE(test::error_of([&] { copy_film_part(film, frames, {45, 46}, part); }).find("expected a part"), std::string::npos);
  EXPECT_NE(test::error_of([&] { copy_film_part(film, frames, {4, 4}, part); }).find("expected a part"), std::string::npos);
}

}  // namespace
}  // namespace tactile::video
