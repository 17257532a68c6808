#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

/// What encodes and decodes is a part that the first call loads (core/loaded_part.hpp), in the programs of tactile alone.
namespace tactile::video {

/// A picture as the bytes of a PNG file.
/// @param picture  8-bit grey or BGR
/// @param name     of the picture, for the error
/// @throws Error   if it cannot be encoded, or the part cannot be loaded
std::vector<unsigned char> png_of(const cv::Mat& picture, const std::string& name);

inline constexpr int widest_page_picture = 640;  ///< [px] of a film, on a page

/// A picture for a page as the bytes of a JPEG file, of quality 80.
/// @param picture  8-bit grey or BGR
/// @param name     of the picture, for the error
/// @throws Error   if it cannot be encoded, or the part cannot be loaded
std::vector<unsigned char> page_jpeg_of(const cv::Mat& picture, const std::string& name);

/// Loads the part now. @throws Error  if it cannot be loaded
void load_picture_codec();

/// The picture of a PNG, JPEG or other file: 8-bit BGR, or empty if it cannot be decoded. Memory is allocated for the size that
/// the file states, so the caller checks it before.
/// @throws Error  if the part cannot be loaded
cv::Mat decoded_picture(std::span<const std::byte> file);

}  // namespace tactile::video
