#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <thread>

#include "support/temporary_folder.hpp"
#include "tactile/video/video_times.hpp"
#include "video/made_film.hpp"

namespace tactile::video {
namespace {

namespace fs = std::filesystem;

pid_t start_filming(const std::string& source, const std::string& speed, const std::string& mp4, const std::string& csv) {
  const pid_t child = fork();
  if (child == 0) {
    execl(FILM_UNTIL_KILLED, FILM_UNTIL_KILLED, source.c_str(), speed.c_str(), mp4.c_str(), csv.c_str(), nullptr);
    _exit(1);
  }
  return child;
}

std::size_t lines_in(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return static_cast<std::size_t>(std::count(std::istreambuf_iterator<char>(in), {}, '\n'));
}

/// From one filmed frame to the next: long where a slow machine drops frames.
microseconds longest_step(const std::vector<VideoTime>& rows) {
  microseconds longest{0};
  for (std::size_t i = 1; i < rows.size(); ++i) longest = std::max(longest, rows[i] - rows[i - 1]);
  return longest;
}

// The moments are counted in frames filmed, and then in microseconds: a slow machine is killed later, not elsewhere.
TEST(VideoKill, TakesNoMoreThanASecondOfTheFilm) {
  const test::TemporaryFolder folder;
  constexpr microseconds step = 70ms;  // 30 frames, a fragment of their own accord, are two seconds
  const std::vector<VideoTime> truth = test::uneven_times(1500, step);
  test::write_film(folder / "source.mp4", truth);

  std::mt19937 random(20240519);
  for (int kill_index = 0; kill_index < 20; ++kill_index) {
    SCOPED_TRACE("kill " + std::to_string(kill_index));
    const std::size_t rows_before = random() % 200;
    const microseconds then{random() % 5'000};
    const fs::path mp4 = folder / (std::to_string(kill_index) + ".mp4"), csv = folder / (std::to_string(kill_index) + ".csv");
    const pid_t child = start_filming((folder / "source.mp4").string(), "60", mp4.string(), csv.string());
    ASSERT_GT(child, 0);
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::minutes(5);
    int status = 0;
    bool ended = false;
    while (!ended && lines_in(csv) < 1 + rows_before && std::chrono::steady_clock::now() < give_up) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      ended = waitpid(child, &status, WNOHANG) == child;
    }
    ASSERT_FALSE(ended) << "the filming process ended by itself with " << status;
    std::this_thread::sleep_for(then);
    kill(child, SIGKILL);
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));

    const std::vector<VideoTime> rows = read_video_times(csv);
    const std::vector<VideoTime> frames = test::decoded_times(mp4);
    ASSERT_GE(rows.size(), rows_before);
    EXPECT_LE(frames.size(), rows.size()) << "a frame in the film without its row";
    for (std::size_t i = 0; i < std::min(frames.size(), rows.size()); ++i) EXPECT_EQ(frames[i], rows[i]) << "frame " << i;
    for (const VideoTime t : rows) EXPECT_TRUE(std::binary_search(truth.begin(), truth.end(), t)) << us_of(t);
    if (rows.empty()) continue;
    const microseconds lost = rows.back() - (frames.empty() ? VideoTime{0us} : frames.back());
    EXPECT_LE(lost, 1s + longest_step(rows)) << "a second, and the step to the frame that would have come next";
  }
}

}  // namespace
}  // namespace tactile::video
