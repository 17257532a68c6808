#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

namespace tactile::video {

/// A picture as the bytes of a PNG file.
/// @param picture  8-bit grey or BGR
/// @throws Error   if it cannot be encoded
std::vector<unsigned char> png_of(const cv::Mat& picture);

/// A picture as the bytes of a JPEG file.
/// @param picture  8-bit grey or BGR
/// @param quality  1 to 100
/// @throws Error   if it cannot be encoded
std::vector<unsigned char> jpeg_of(const cv::Mat& picture, int quality);

/// The picture of a PNG, JPEG or other file: 8-bit BGR, or empty if it cannot be decoded. Memory is allocated for the size that
/// the file states, so the caller checks it before.
cv::Mat decoded_picture(std::span<const std::byte> file);

}  // namespace tactile::video
