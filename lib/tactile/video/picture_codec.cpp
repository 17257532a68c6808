#include "tactile/video/picture_codec.hpp"

#include <opencv2/imgcodecs.hpp>

#include "tactile/core/error.hpp"
#include "tactile/video/load_opencv.hpp"

namespace tactile::video {
namespace {

std::vector<unsigned char> encoded(const char* extension, const cv::Mat& picture, const std::vector<int>& options,
                                   const std::string& name) {
  std::vector<unsigned char> bytes = opencv_part().encode(extension, picture, options);
  if (bytes.empty()) throw Error(name + ": cannot be encoded as a picture; expected grey or BGR bytes");
  return bytes;
}

}  // namespace

std::vector<unsigned char> png_of(const cv::Mat& picture, const std::string& name) { return encoded(".png", picture, {}, name); }

std::vector<unsigned char> page_jpeg_of(const cv::Mat& picture, const std::string& name) {
  return encoded(".jpg", picture, {cv::IMWRITE_JPEG_QUALITY, 80}, name);
}

void load_picture_codec() { opencv_part(); }

cv::Mat decoded_picture(std::span<const std::byte> file) { return opencv_part().decode(file); }

}  // namespace tactile::video
