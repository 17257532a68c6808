#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/video/video_source.hpp"

namespace tactile::video {

/// What `tactile-opencv.so` provides: cameras and the formats of pictures. It is loaded at the first use, because OpenCV loads 80
/// libraries for them, which takes 0.2 s.
struct OpenCvPart {
  std::unique_ptr<VideoSource> (*open_video_source)(const std::string& source);
  /// @param extension  of the format, ".png"
  /// @param options    as of cv::imencode
  /// @return empty if the picture cannot be encoded
  std::vector<unsigned char> (*encode)(const char* extension, const cv::Mat& picture, const std::vector<int>& options);
  /// @return empty if the file cannot be decoded
  cv::Mat (*decode)(std::span<const std::byte> file);
};

}  // namespace tactile::video
