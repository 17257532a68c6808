#include "tactile/video/film_picture.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace tactile::video {

cv::Size film_size(cv::Size size) { return {size.width + size.width % 2, size.height + size.height % 2}; }

cv::Mat film_picture(const cv::Mat& picture, cv::Size size) {
  cv::Mat plain = picture;
  if (plain.depth() == CV_16U) picture.convertTo(plain, CV_8U, 1.0 / 256, -0.498);  // rounds down
  if (plain.empty() || plain.depth() != CV_8U || plain.channels() == 2 || plain.channels() > 4) return {};
  if (plain.channels() == 4) cv::cvtColor(plain, plain, cv::COLOR_BGRA2BGR);
  if (plain.size() != size) cv::resize(plain, plain, size, 0, 0, cv::INTER_AREA);
  const cv::Size even = film_size(size);
  if (even != size)
    cv::copyMakeBorder(plain, plain, 0, even.height - size.height, 0, even.width - size.width, cv::BORDER_REPLICATE);
  return plain;
}

}  // namespace tactile::video
