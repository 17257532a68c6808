#include "tactile/video/video_writer.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <utility>
#include <vector>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::video {
namespace {

/// Times like a webcam's: about 30 a second, one frame dropped, one late.
std::vector<VideoTime> uneven_times() {
  std::vector<VideoTime> times;
  std::int64_t us = 0;
  for (int i = 0; i < 70; ++i) {
    times.emplace_back(microseconds{us});
    us += 33'333 + (i * 7919) % 1511 - 700 + (i == 20 ? 33'333 : 0) + (i == 41 ? 9'001 : 0);
  }
  return times;
}

/// Dark, with a brighter square that wanders to the right; its column tells the frame.
cv::Mat frame_with_square(int index, int type) {
  cv::Mat frame(64, 96, type, cv::Scalar::all(40));
  frame(cv::Rect(index, 20, 16, 16)).setTo(cv::Scalar::all(200));
  return frame;
}

void write_film(const std::filesystem::path& file, int type, bool fast = false) {
  VideoWriter writer(file, {.width = 96, .height = 64, .fast = fast});
  int index = 0;
  for (const VideoTime t : uneven_times()) writer.write(frame_with_square(index++, type), t);
  writer.close();
}

TEST(VideoWriter, KeepsEveryFrameAndItsTime) {
  for (const auto& [type, fast] : {std::pair{CV_8UC1, false}, {CV_8UC3, false}, {CV_8UC1, true}, {CV_8UC3, true}}) {
    const test::TemporaryFolder folder;
    write_film(folder / "video.mp4", type, fast);
    cv::VideoCapture film((folder / "video.mp4").string(), cv::CAP_FFMPEG);
    ASSERT_TRUE(film.isOpened());
    const std::vector<VideoTime> times = uneven_times();
    cv::Mat frame;
    for (std::size_t i = 0; i < times.size(); ++i) {
      ASSERT_TRUE(film.read(frame)) << "frame " << i;
      EXPECT_NEAR(film.get(cv::CAP_PROP_POS_MSEC), static_cast<double>(us_of(times[i])) / 1000.0, 1e-3) << "frame " << i;
      const cv::Mat expected = frame_with_square(static_cast<int>(i), CV_8UC3);
      EXPECT_LT(cv::norm(frame, expected, cv::NORM_L1) / static_cast<double>(expected.total() * 3), 4.0) << "frame " << i;
    }
    EXPECT_FALSE(film.read(frame));
  }
}

/// Memory after whose last byte nothing may be read.
class GuardedMemory {
 public:
  explicit GuardedMemory(std::size_t size) : size_(size) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    readable_ = (size + page - 1) / page * page;
    all_ = readable_ + page;
    begin_ = static_cast<std::byte*>(mmap(nullptr, all_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    if (begin_ == MAP_FAILED || mprotect(begin_ + readable_, page, PROT_NONE) != 0) std::abort();
  }
  ~GuardedMemory() { munmap(begin_, all_); }
  GuardedMemory(const GuardedMemory&) = delete;
  GuardedMemory& operator=(const GuardedMemory&) = delete;

  std::byte* data() const { return begin_ + (readable_ - size_); }

 private:
  std::size_t size_, readable_ = 0, all_ = 0;
  std::byte* begin_ = nullptr;
};

TEST(VideoWriter, NeverReadsBeyondTheEndOfAFrame) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (const cv::Size size : {cv::Size(2, 2), cv::Size(34, 6), cv::Size(66, 50), cv::Size(640, 480)}) {
      const test::TemporaryFolder folder;
      const GuardedMemory memory(static_cast<std::size_t>(size.area()) * CV_ELEM_SIZE(type));
      const cv::Mat frame(size, type, memory.data());
      VideoWriter writer(folder / "video.mp4", {.width = size.width, .height = size.height});
      writer.write(frame, VideoTime{});
      writer.close();
      cv::VideoCapture film((folder / "video.mp4").string(), cv::CAP_FFMPEG);
      cv::Mat read;
      ASSERT_TRUE(film.read(read));
      EXPECT_EQ(read.size(), size);
    }
  }
}

TEST(VideoWriter, GivesTheSameBytesForTheSameFrames) {
  const test::TemporaryFolder folder;
  write_film(folder / "a.mp4", CV_8UC1);
  write_film(folder / "b.mp4", CV_8UC1);
  EXPECT_EQ(read_text(folder / "a.mp4"), read_text(folder / "b.mp4"));
  write_film(folder / "c.mp4", CV_8UC1, true);
  write_film(folder / "d.mp4", CV_8UC1, true);
  EXPECT_EQ(read_text(folder / "c.mp4"), read_text(folder / "d.mp4"));
}

TEST(VideoWriter, KeepsEveryGreyLevel) {
  const test::TemporaryFolder folder;
  for (const bool fast : {false, true}) {
    cv::Mat ramp(64, 256, CV_8UC1);
    for (int x = 0; x < ramp.cols; ++x) ramp.col(x).setTo(x);
    const std::filesystem::path file = folder / (fast ? "fast.mp4" : "slow.mp4");
    VideoWriter writer(file, {.width = 256, .height = 64, .quality = 1, .fast = fast});
    writer.write(ramp, VideoTime{0us});
    writer.close();
    cv::VideoCapture film(file.string(), cv::CAP_FFMPEG);
    cv::Mat frame;
    ASSERT_TRUE(film.read(frame));
    for (int x = 0; x < ramp.cols; ++x) {
      for (int channel = 0; channel < 3; ++channel) ASSERT_NEAR(frame.at<cv::Vec3b>(32, x)[channel], x, 3) << x;
    }
  }
}

TEST(VideoWriter, LeavesWholeFragmentsWhenItIsCutOff) {
  const test::TemporaryFolder folder;
  write_film(folder / "video.mp4", CV_8UC1);
  const std::string whole = read_text(folder / "video.mp4");
  const std::size_t third = whole.rfind("moof") - 4;  // 70 frames are three fragments of 30, 30 and 10
  write_whole(folder / "cut.mp4", whole.substr(0, third));
  cv::VideoCapture film((folder / "cut.mp4").string(), cv::CAP_FFMPEG);
  ASSERT_TRUE(film.isOpened());
  cv::Mat frame;
  int frames = 0;
  while (film.read(frame)) ++frames;
  EXPECT_EQ(frames, 60);
}

TEST(VideoWriter, PutsEverySecondIntoTheFileWhereAskedTo) {
  const test::TemporaryFolder folder;
  VideoWriterOptions options{.width = 96, .height = 64};
  options.fragment_span = 1s;
  VideoWriter writer(folder / "video.mp4", options);
  const auto frames_in_file = [&] {
    cv::VideoCapture film((folder / "video.mp4").string(), cv::CAP_FFMPEG);
    cv::Mat frame;
    int frames = 0;
    while (film.isOpened() && film.read(frame)) ++frames;
    return frames;
  };
  // 10 frames a second: a fragment of 30 frames alone would be three seconds long.
  for (int i = 0; i <= 30; ++i) {
    writer.write(frame_with_square(i, CV_8UC1), VideoTime{100ms * i});
    EXPECT_EQ(frames_in_file(), i / 10 * 10) << "after frame " << i;
  }
  writer.close();
  EXPECT_EQ(frames_in_file(), 31);
}

TEST(VideoWriter, RefusesWhatItCannotWrite) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(VideoWriter(folder / "a.mp4", {.width = 95, .height = 64}), Error) << "an odd side";
  EXPECT_THROW(VideoWriter(folder / "a.mp4", {.quality = 52}), Error);
  EXPECT_THROW(VideoWriter("/nowhere/a.mp4", {}), Error);
  VideoWriterOptions backwards;
  backwards.fragment_span = -1us;
  EXPECT_THROW(VideoWriter(folder / "a.mp4", backwards), Error);
  VideoWriter writer(folder / "b.mp4", {.width = 96, .height = 64});
  EXPECT_THROW(writer.write(cv::Mat(64, 95, CV_8UC1), VideoTime{0us}), Error) << "another size";
  EXPECT_THROW(writer.write(cv::Mat(64, 96, CV_32FC1), VideoTime{0us}), Error) << "another type";
  EXPECT_THROW(writer.write(frame_with_square(0, CV_8UC1), VideoTime{5us}), Error) << "a first frame not at 0";
  writer.write(frame_with_square(0, CV_8UC1), VideoTime{0us});
  EXPECT_THROW(writer.write(frame_with_square(1, CV_8UC1), VideoTime{0us}), Error) << "a time twice";
}

}  // namespace
}  // namespace tactile::video
