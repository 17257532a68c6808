#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace tactile {

/// What `VideoWriter` takes for a film of pictures of `size`: [height, width] 8-bit grey or BGR, both sides even.
///
/// A picture of another size is resized, alpha left out, the upper 8 of 16 bits kept; where a side of `size` is odd the last row
/// or column stands twice, since H.264 halves the colours' sides.
///
/// @return  empty if the picture is, or has pixels of another kind: neither 8 nor 16 bits, or of 2 or more than 4 channels
cv::Mat film_picture(const cv::Mat& picture, cv::Size size);

/// The sides of what `film_picture` returns.
cv::Size film_size(cv::Size size);

}  // namespace tactile
