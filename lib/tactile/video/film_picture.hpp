#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace tactile::video {

/// Makes of a picture what `VideoWriter` takes for a film of `size`: [height, width] 8-bit grey or BGR, both sides even.
///
/// A picture of another size is resized. Alpha is left out, and the upper 8 of 16 bits are kept. Where a side of `size` is odd
/// the last row or column is repeated, since H.264 halves the sides of the colours.
///
/// @return  empty if the picture is empty, has neither 8 nor 16 bits, or has 2 or more than 4 channels
cv::Mat film_picture(const cv::Mat& picture, cv::Size size);

/// The size of the pictures that `film_picture` returns.
cv::Size film_size(cv::Size size);

}  // namespace tactile::video
