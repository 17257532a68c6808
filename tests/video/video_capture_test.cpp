#include "tactile/video/video_capture.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>

extern "C" {
#include <libavformat/avformat.h>
}

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/video/video_times.hpp"
#include "video/made_film.hpp"

namespace tactile::video {
namespace {

namespace fs = std::filesystem;

/// The times of a video's packets as libavformat tells them, from the first on.
std::vector<std::int64_t> packet_times_us(const fs::path& file) {
  AVFormatContext* format = nullptr;
  if (avformat_open_input(&format, file.c_str(), nullptr, nullptr) < 0) throw Error(file.string() + ": cannot be opened");
  std::vector<std::int64_t> times;
  AVPacket* packet = av_packet_alloc();
  while (av_read_frame(format, packet) >= 0) {
    times.push_back(av_rescale_q(packet->pts, format->streams[packet->stream_index]->time_base, {1, 1'000'000}));
    av_packet_unref(packet);
  }
  av_packet_free(&packet);
  avformat_close_input(&format);
  const std::int64_t first = times.empty() ? 0 : times.front();
  for (std::int64_t& t : times) t -= first;
  return times;
}

/// JPEGs one after the other: a video to libavformat, of 25 frames a second, whose frames may be of any size.
void write_jpegs(const fs::path& file, const std::vector<cv::Mat>& pictures) {
  std::ofstream out(file, std::ios::binary);
  for (const cv::Mat& picture : pictures) {
    std::vector<unsigned char> jpeg;
    cv::imencode(".jpg", picture, jpeg);
    out.write(reinterpret_cast<const char*>(jpeg.data()), static_cast<std::streamsize>(jpeg.size()));
  }
}

/// Waits until `state` is as wanted. What is waited for always comes; the bound is for a capture that hangs.
template <class Wanted>
VideoCaptureState wait_until(const VideoCapture& capture, const Wanted& wanted) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  VideoCaptureState state = capture.state();
  while (!wanted(state) && std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    state = capture.state();
  }
  EXPECT_TRUE(wanted(state)) << "waited in vain: " << state.frames << " frames, " << state.dropped << " dropped";
  return state;
}

bool has_ended(const VideoCaptureState& state) { return !state.running && state.queued == 0; }

class VideoCaptureTest : public testing::Test {
 protected:
  /// Films `source` from its first frame to its last.
  VideoCaptureState film_whole(const fs::path& source, double speed = 0) {
    VideoCapture capture({.source = source.string(), .speed = speed, .log = keeper()});
    capture.start_film(mp4, csv);
    wait_until(capture, has_ended);
    capture.stop_film();
    return capture.state();
  }
  std::function<void(const std::string&)> keeper() {
    return [this](const std::string& line) {
      const std::scoped_lock lock(guard);
      logged.push_back(line);
    };
  }

  test::TemporaryFolder folder;
  const fs::path mp4 = folder / "video.mp4", csv = folder / "video.csv";
  std::mutex guard;
  std::vector<std::string> logged;
};

TEST_F(VideoCaptureTest, GivesTheTrueTimesOfAFileWithAVariableRate) {
  const std::vector<VideoTime> times = test::uneven_times(120, 33'333us);
  test::write_film(folder / "source.mp4", times);
  const std::int64_t before = us_of(host_now());
  const VideoCaptureState state = film_whole(folder / "source.mp4");
  EXPECT_EQ(state.frames, times.size());
  EXPECT_EQ(state.dropped, 0U);
  EXPECT_FALSE(state.running);
  EXPECT_TRUE(state.error.empty()) << state.error;

  const std::vector<VideoTime> rows = read_video_times(csv);
  const std::vector<std::int64_t> in_source = packet_times_us(folder / "source.mp4"), in_film = packet_times_us(mp4);
  ASSERT_EQ(rows.size(), in_source.size());
  ASSERT_EQ(rows.size(), in_film.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(us_of(rows[i])), static_cast<double>(in_source[i]), 1.0) << "frame " << i;
    EXPECT_EQ(us_of(rows[i]), in_film[i]) << "frame " << i;
  }
  EXPECT_EQ(test::decoded_times(mp4), rows);

  std::ifstream in(csv);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "index,pts_us,host_time_us");
  std::int64_t last = before;
  while (std::getline(in, line)) {
    const std::int64_t host = std::stoll(line.substr(line.rfind(',') + 1));
    EXPECT_GE(host, last);
    last = host;
  }
  EXPECT_LE(last, us_of(host_now()));
  ASSERT_EQ(logged.size(), 1U);
  EXPECT_NE(logged[0].find("has ended"), std::string::npos) << logged[0];
}

TEST_F(VideoCaptureTest, KeepsTheOrderOfTheFrames) {
  test::write_film(folder / "source.mp4", test::uneven_times(60, 33ms));
  film_whole(folder / "source.mp4");
  cv::VideoCapture film(mp4.string(), cv::CAP_FFMPEG);
  cv::Mat frame;
  for (std::size_t i = 0; i < 60; ++i) {
    ASSERT_TRUE(film.read(frame));
    const cv::Mat expected = test::frame_with_square(i);
    EXPECT_LT(cv::norm(frame, expected, cv::NORM_L1) / static_cast<double>(expected.total() * 3), 5.0) << "frame " << i;
  }
}

TEST_F(VideoCaptureTest, KeepsAFilesPace) {
  test::write_film(folder / "source.mp4", test::uneven_times(20, 20ms));
  const auto begun = std::chrono::steady_clock::now();
  const VideoCaptureState state = film_whole(folder / "source.mp4", 1);
  const auto times = read_video_times(csv);
  EXPECT_GE(std::chrono::steady_clock::now() - begun, times.back() - times.front()) << "faster than its own times";
  ASSERT_TRUE(state.clock);
  EXPECT_LT(std::abs(us_of(host_now()) - state.clock->offset.count()), 60'000'000) << "frames count from the film's beginning";
}

TEST_F(VideoCaptureTest, HasNoClockAtAnotherPace) {
  test::write_film(folder / "source.mp4", test::uneven_times(20, 20ms));
  EXPECT_FALSE(film_whole(folder / "source.mp4").clock);
}

TEST_F(VideoCaptureTest, MakesFilmAfterFilmOfOneSource) {
  test::write_film(folder / "source.mp4", test::uneven_times(2000, 33ms));  // a minute, of which a second or two is filmed
  VideoCapture capture({.source = (folder / "source.mp4").string(), .speed = 1, .log = {}});
  for (int film = 0; film < 3; ++film) {
    const fs::path film_mp4 = folder / (std::to_string(film) + ".mp4"), film_csv = folder / (std::to_string(film) + ".csv");
    capture.start_film(film_mp4, film_csv);
    EXPECT_THROW(capture.start_film(mp4, csv), Error) << "two at once";
    wait_until(capture, [](const VideoCaptureState& state) { return state.frames >= 20; });
    capture.stop_film();
    const std::vector<VideoTime> rows = read_video_times(film_csv);
    EXPECT_EQ(rows.size(), capture.state().frames);
    EXPECT_EQ(us_of(rows.front()), 0);
    EXPECT_EQ(test::decoded_times(film_mp4), rows);
  }
  capture.stop_film();  // there is none: nothing happens
}

TEST_F(VideoCaptureTest, CountsWhatASlowEncoderCannotTake) {
  // Few bits to decode, but no two frames alike: writing them without loss takes far longer than reading them.
  constexpr std::size_t count = 150;
  {
    VideoWriter source(folder / "source.mp4", {.width = 1280, .height = 720, .quality = 45});
    cv::RNG random(1);
    cv::Mat small(18, 32, CV_8UC1), frame;
    for (std::size_t i = 0; i < count; ++i) {
      random.fill(small, cv::RNG::UNIFORM, 0, 256);
      cv::resize(small, frame, {1280, 720}, 0, 0, cv::INTER_CUBIC);
      source.write(frame, VideoTime{33ms * i});
    }
    source.close();
  }
  VideoCapture capture({.source = (folder / "source.mp4").string(), .speed = 1e6, .quality = 0, .queue = 1, .log = {}});
  capture.start_film(mp4, csv);
  wait_until(capture, has_ended);
  capture.stop_film();
  const VideoCaptureState state = capture.state();
  EXPECT_GT(state.dropped, 0U);
  EXPECT_GT(state.frames, 0U);
  EXPECT_EQ(state.frames + state.dropped, count);
  EXPECT_EQ(read_video_times(csv).size(), state.frames);
  EXPECT_EQ(test::decoded_times(mp4).size(), state.frames);
  RecordProperty("dropped", static_cast<int>(state.dropped));
}

TEST_F(VideoCaptureTest, FilmsFramesWithOddSides) {
  std::vector<cv::Mat> pictures;
  for (std::size_t i = 0; i < 10; ++i) pictures.push_back(test::frame_with_square(i, {95, 63}));
  write_jpegs(folder / "source.mjpeg", pictures);
  EXPECT_EQ(film_whole(folder / "source.mjpeg").frames, 10U);
  cv::VideoCapture film(mp4.string(), cv::CAP_FFMPEG);
  cv::Mat frame;
  ASSERT_TRUE(film.read(frame));
  EXPECT_EQ(frame.size(), cv::Size(96, 64)) << "the last row and column stand twice";
  EXPECT_LT(cv::norm(frame(cv::Rect(0, 0, 95, 63)), pictures[0], cv::NORM_L1) / static_cast<double>(95 * 63 * 3), 5.0);
}

TEST_F(VideoCaptureTest, FilmsGreyFramesAndContinuesWhereTheirSizeChanges) {
  std::vector<cv::Mat> pictures(10, cv::Mat(64, 96, CV_8UC1, cv::Scalar(90)));
  pictures.insert(pictures.end(), 10, cv::Mat(128, 60, CV_8UC3, cv::Scalar::all(180)));
  write_jpegs(folder / "source.mjpeg", pictures);
  EXPECT_EQ(film_whole(folder / "source.mjpeg").frames, 20U);
  cv::VideoCapture film(mp4.string(), cv::CAP_FFMPEG);
  cv::Mat frame;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(film.read(frame));
    EXPECT_EQ(frame.size(), cv::Size(96, 64));
    if (i >= 10) continue;  // what OpenCV makes of the others hangs on its version
    EXPECT_NEAR(cv::mean(frame)[0], 90, 4) << "frame " << i;
  }
}

TEST_F(VideoCaptureTest, ReportsWhatIsWrongWithASource) {
  write_whole(folder / "text.mp4", "no video at all");
  fs::create_directory(folder / "empty");
  for (const std::string& source : {(folder / "none.mp4").string(), (folder / "text.mp4").string(), (folder / "empty").string(),
                                    std::string("999"), std::string("/dev/video999"), std::string("/dev/null"),
                                    std::string("http://127.0.0.1:1/film.mp4"), std::string("nonsense://x"), std::string()}) {
    try {
      const VideoCapture capture({.source = source, .log = {}});
      ADD_FAILURE() << source << " was opened";
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()).find(source), 0U) << e.what();
      EXPECT_NE(std::string(e.what()).find("expected"), std::string::npos) << e.what();
    }
  }
}

TEST_F(VideoCaptureTest, RefusesOptionsOutOfRange) {
  test::write_film(folder / "source.mp4", test::uneven_times(3, 33ms));
  const std::string source = (folder / "source.mp4").string();
  EXPECT_THROW(VideoCapture({.source = source, .speed = -1, .log = {}}), Error);
  EXPECT_THROW(VideoCapture({.source = source, .quality = 52, .log = {}}), Error);
  EXPECT_THROW(VideoCapture({.source = source, .queue = 0, .log = {}}), Error);
}

TEST_F(VideoCaptureTest, NeverWritesOverAFile) {
  test::write_film(folder / "source.mp4", test::uneven_times(10, 33ms));
  VideoCapture capture({.source = (folder / "source.mp4").string(), .speed = 0, .log = {}});
  write_whole(mp4, "old");
  EXPECT_THROW(capture.start_film(mp4, csv), Error);
  EXPECT_EQ(read_text(mp4), "old");
  EXPECT_FALSE(fs::exists(csv));
  write_whole(csv, "old");
  EXPECT_THROW(capture.start_film(folder / "new.mp4", csv), Error);
  EXPECT_EQ(read_text(csv), "old");
  EXPECT_FALSE(fs::exists(folder / "new.mp4"));
  EXPECT_THROW(capture.start_film("/nowhere/a.mp4", "/nowhere/a.csv"), Error);
  capture.start_film(folder / "new.mp4", folder / "new.csv");
  wait_until(capture, has_ended);
  capture.stop_film();
  EXPECT_EQ(capture.state().frames, 10U) << "a file waits for its first film";
  EXPECT_THROW(capture.start_film(folder / "late.mp4", folder / "late.csv"), Error) << "the source has ended";
}

TEST_F(VideoCaptureTest, KeepsWhatIsFilmedWhenItGoesWithoutBeingStopped) {
  test::write_film(folder / "source.mp4", test::uneven_times(400, 33ms));
  {
    VideoCapture capture({.source = (folder / "source.mp4").string(), .speed = 10, .log = {}});
    capture.start_film(mp4, csv);
    wait_until(capture, [](const VideoCaptureState& state) { return state.frames >= 10; });
  }
  EXPECT_GE(read_video_times(csv).size(), 10U);
  EXPECT_EQ(test::decoded_times(mp4), read_video_times(csv));
}

/// For its lifetime no file grows beyond `bytes`: what a full disk looks like to a writer.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit full{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &full);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

TEST_F(VideoCaptureTest, KeepsWhatADiskTookBeforeItWasFull) {
  test::write_film(folder / "source.mp4", test::uneven_times(2000, 33ms));  // a minute, of which the disk takes seconds
  VideoCapture capture({.source = (folder / "source.mp4").string(), .speed = 1, .quality = 10, .log = keeper()});
  {
    const FullDisk full(60'000);
    capture.start_film(mp4, csv);
    wait_until(capture, [](const VideoCaptureState& state) { return !state.error.empty() && state.dropped > 5; });
    EXPECT_TRUE(capture.state().running) << "the source is still there";
    EXPECT_THROW(capture.stop_film(), Error);
  }
  ASSERT_EQ(logged.size(), 1U);
  EXPECT_NE(logged[0].find("video.mp4"), std::string::npos) << logged[0];
  const std::vector<VideoTime> rows = read_video_times(csv), frames = test::decoded_times(mp4);
  EXPECT_GT(frames.size(), 30U) << "at least a fragment";
  EXPECT_LE(rows.size() - frames.size(), 62U) << "no more than two fragments are lost";
  EXPECT_TRUE(std::equal(frames.begin(), frames.end(), rows.begin()));

  capture.start_film(folder / "next.mp4", folder / "next.csv");
  EXPECT_TRUE(capture.state().error.empty());
  wait_until(capture, [](const VideoCaptureState& state) { return state.frames > 5; });
  EXPECT_NO_THROW(capture.stop_film());
}

TEST_F(VideoCaptureTest, GoesWithoutEverHavingFilmed) {
  test::write_film(folder / "source.mp4", test::uneven_times(40, 33ms));
  for (const double speed : {0.0, 1.0}) {
    const VideoCapture capture({.source = (folder / "source.mp4").string(), .speed = speed, .log = keeper()});
    EXPECT_TRUE(capture.state().running);
  }
  EXPECT_TRUE(logged.empty()) << "it was asked to end";
}

/// An HTTP server on a loopback port that sends `answer` to whoever connects, and then nothing more.
class StallingServer {
 public:
  explicit StallingServer(std::string answer) : answer_(std::move(answer)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    auto* plain = reinterpret_cast<sockaddr*>(&address);
    if (bind(listener_, plain, length) != 0 || listen(listener_, 8) != 0 || getsockname(listener_, plain, &length) != 0)
      throw Error("no loopback port; expected a free one");
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] {
      for (int client = 0; (client = accept(listener_, nullptr, nullptr)) >= 0; clients_.push_back(client)) {
        for (std::size_t sent = 0; sent < answer_.size();) {
          const ssize_t now = send(client, answer_.data() + sent, answer_.size() - sent, MSG_NOSIGNAL);
          if (now <= 0) break;
          sent += static_cast<std::size_t>(now);
        }
      }
    });
  }
  ~StallingServer() {
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    for (const int client : clients_) close(client);
    close(listener_);
  }
  StallingServer(const StallingServer&) = delete;
  StallingServer& operator=(const StallingServer&) = delete;

  std::string url(const std::string& path) const { return "http://127.0.0.1:" + std::to_string(port_) + path; }

 private:
  std::string answer_;
  int listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  int port_ = 0;
  std::vector<int> clients_;
  std::thread thread_;
};

TEST_F(VideoCaptureTest, GivesUpAServerThatNeverAnswers) {
  const StallingServer server("");
  EXPECT_THROW(VideoCapture({.source = server.url("/film.mp4"), .log = {}}), Error);
}

TEST_F(VideoCaptureTest, EndsTheFilmOfAServerThatStopsSending) {
  test::write_film(folder / "source.mp4", test::uneven_times(200, 33ms));
  const std::string whole = read_text(folder / "source.mp4");
  const StallingServer server("HTTP/1.0 200 OK\r\nContent-Type: video/mp4\r\n\r\n" + whole.substr(0, whole.size() / 2));
  VideoCapture capture({.source = server.url("/film.mp4"), .speed = 20, .log = keeper()});
  capture.start_film(mp4, csv);
  wait_until(capture, has_ended);
  capture.stop_film();
  EXPECT_GT(capture.state().frames, 0U);
  EXPECT_EQ(test::decoded_times(mp4), read_video_times(csv));
  EXPECT_EQ(logged.size(), 1U);

  VideoCapture other({.source = server.url("/film.mp4"), .log = {}});  // goes while its server is silent
  other.start_film(folder / "other.mp4", folder / "other.csv");
}

}  // namespace
}  // namespace tactile::video
