#pragma once

#include <cstdint>
#include <opencv2/videoio.hpp>
#include <string>

#include "tactile/core/time.hpp"

namespace tactile::video {

/// An open device, file or URL.
struct VideoSource {
  enum class Kind : std::uint8_t { device, file, url };

  cv::VideoCapture capture;
  Kind kind = Kind::file;
  bool recorded = false;  ///< it has a known end, and its own pace
};

/// Silences the messages of OpenCV and libavformat in the process. A URL may take 5 s to answer, here and for every frame.
/// @param source  a device's number ("0") or path ("/dev/video0"), a file, or a URL
/// @throws Error  if it cannot be opened
VideoSource open_video_source(const std::string& source);

/// The time from frame to frame by the source's own rate; 40 ms where it has none.
microseconds nominal_step(const cv::VideoCapture& capture);

}  // namespace tactile::video
