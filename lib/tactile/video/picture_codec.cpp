#include "tactile/video/picture_codec.hpp"

#include <opencv2/imgcodecs.hpp>

#include "tactile/core/error.hpp"
#include "tactile/core/loaded_part.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/video/opencv_part.hpp"
#include "tactile/video/video_source.hpp"

namespace tactile::video {
namespace {

// The part calls functions of the program that loads it. This keeps the file that it calls in each such program.
[[gnu::used]] const auto called_by_part = &whole_number_in;

const OpenCvPart& opencv_part() {
  static const auto& part =
      *static_cast<const OpenCvPart*>(load_part("tactile-opencv.so", "tactile_opencv_part", std::size_t{256} << 20));
  return part;
}

std::vector<unsigned char> encoded(const char* extension, const cv::Mat& picture, const std::vector<int>& options,
                                   const std::string& name) {
  std::vector<unsigned char> bytes = opencv_part().encode(extension, picture, options);
  if (bytes.empty()) throw Error(name + ": cannot be encoded as a picture; expected grey or BGR bytes");
  return bytes;
}

}  // namespace

std::unique_ptr<VideoSource> open_video_source(const std::string& source) { return opencv_part().open_video_source(source); }

std::vector<unsigned char> png_of(const cv::Mat& picture, const std::string& name) { return encoded(".png", picture, {}, name); }

std::vector<unsigned char> jpeg_of(const cv::Mat& picture, int quality, const std::string& name) {
  return encoded(".jpg", picture, {cv::IMWRITE_JPEG_QUALITY, quality}, name);
}

void load_picture_codec() { opencv_part(); }

cv::Mat decoded_picture(std::span<const std::byte> file) { return opencv_part().decode(file); }

}  // namespace tactile::video
