#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "tactile/core/time.hpp"

namespace tactile::video {

/// An open device, file or URL.
class VideoSource {
 public:
  VideoSource() = default;
  VideoSource(const VideoSource&) = delete;
  VideoSource& operator=(const VideoSource&) = delete;
  virtual ~VideoSource() = default;

  /// Takes the next frame. @return false once the source has ended
  virtual bool grab() = 0;

  /// The time of the frame that was taken, by the source; any value.
  virtual double time_ms() const = 0;

  /// The pixels of the frame that was taken. @return false if they cannot be decoded
  virtual bool decode(cv::Mat& into) = 0;

  virtual void close() = 0;

  /// The time from frame to frame by the source's own rate; 40 ms where it has none.
  virtual microseconds nominal_step() const = 0;

  /// Whether it has a known end, and its own pace.
  virtual bool is_recorded() const = 0;
};

/// Silences the messages of OpenCV and libavformat in the process. A URL may take 5 s to answer, here and for every frame.
/// @param source  a device's number ("0") or path ("/dev/video0"), a file, or a URL
/// @throws Error  if it cannot be opened, or the part that opens it cannot be loaded (core/loaded_part.hpp)
std::unique_ptr<VideoSource> open_video_source(const std::string& source);

}  // namespace tactile::video
