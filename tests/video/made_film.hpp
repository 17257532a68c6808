#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "tactile/video/video_writer.hpp"

namespace tactile::test {

/// Times of frames that come `step` apart, each up to a quarter of it early or late, now and then one left out.
inline std::vector<VideoTime> uneven_times(std::size_t count, microseconds step, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::int64_t> early_or_late(-step.count() / 4, step.count() / 4);
  std::vector<VideoTime> times;
  microseconds t{0};
  for (std::size_t i = 0; i < count; ++i) {
    times.emplace_back(t);
    t += step + microseconds{early_or_late(random)} + (i % 37 == 20 ? step : 0us);
  }
  return times;
}

/// Dark, with a brighter square whose place tells the frame.
inline cv::Mat frame_with_square(std::size_t index, cv::Size size = {96, 64}) {
  cv::Mat frame(size, CV_8UC3, cv::Scalar::all(40));
  const int column = static_cast<int>(index % 40) * 2;
  frame(cv::Rect(column, 20, 16, 16)).setTo(cv::Scalar::all(200));
  return frame;
}

inline void write_film(const std::filesystem::path& file, std::span<const VideoTime> times) {
  video::VideoWriter writer(file, {.width = 96, .height = 64});
  std::size_t index = 0;
  for (const VideoTime t : times) writer.write(frame_with_square(index++), t);
  writer.close();
}

/// The times of the frames that OpenCV decodes. @throws std::runtime_error if it cannot open the file
inline std::vector<VideoTime> decoded_times(const std::filesystem::path& file) {
  cv::VideoCapture film(file.string(), cv::CAP_FFMPEG);
  if (!film.isOpened()) throw std::runtime_error("cannot open " + file.string());
  std::vector<VideoTime> times;
  for (cv::Mat frame; film.read(frame);) times.emplace_back(microseconds{std::llround(1000 * film.get(cv::CAP_PROP_POS_MSEC))});
  return times;
}

}  // namespace tactile::test
