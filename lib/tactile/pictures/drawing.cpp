#include "tactile/pictures/drawing.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace tactile::pictures {
namespace {

/// The font draws nothing else.
std::string as_ascii(const std::string& text) {
  std::string ascii;
  for (const char c : text) {
    if (c >= ' ' && c <= '~')
      ascii += c;
    else if ((static_cast<unsigned char>(c) & 0xC0U) != 0x80U)
      ascii += '?';  // one for a character of several bytes
  }
  return ascii;
}

int ascii_width(const std::string& text, double size) {
  int below = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &below).width;
}

std::string fitted(const std::string& text, double size, int width) {
  std::string ascii = as_ascii(text);
  if (ascii_width(ascii, size) <= width) return ascii;
  for (std::size_t kept = ascii.size(); kept-- > 0;) {
    std::string shorter = ascii.substr(0, (kept + 1) / 2) + "..." + ascii.substr(ascii.size() - kept / 2);
    if (ascii_width(shorter, size) <= width) return shorter;
  }
  return {};
}

/// Where the source pixels of each of `count` pixels begin, and after the last one where they end.
std::vector<int> source_bounds(int source, int count) {
  std::vector<int> bounds;
  for (int i = 0; i <= count; ++i) bounds.push_back(static_cast<int>(std::int64_t{i} * source / count));
  return bounds;
}

template <class Value>
void keep_largest(const cv::Mat& picture, cv::Mat& smaller) {
  const std::vector<int> columns = source_bounds(picture.cols, smaller.cols), rows = source_bounds(picture.rows, smaller.rows);
  for (int y = 0; y < smaller.rows; ++y) {
    auto* const to = smaller.ptr<Value>(y);
    for (int source_y = rows[static_cast<std::size_t>(y)]; source_y < rows[static_cast<std::size_t>(y) + 1]; ++source_y) {
      const auto* const from = picture.ptr<Value>(source_y);
      for (std::size_t x = 0; x + 1 < columns.size(); ++x) {
        for (int source_x = columns[x]; source_x < columns[x + 1]; ++source_x) to[x] = std::max(to[x], from[source_x]);
      }
    }
  }
}

}  // namespace

cv::Scalar touch_colour(const std::optional<Touch>& touch) {
  if (touch == Touch::press) return {200, 90, 0};
  if (touch == Touch::slip) return {0, 90, 230};
  return {170, 170, 170};
}

cv::Scalar light_touch_colour(Touch touch) {
  if (touch == Touch::press) return {248, 224, 204};
  if (touch == Touch::slip) return {200, 222, 252};
  return paper;
}

int text_width(const std::string& text, double size) { return ascii_width(as_ascii(text), size); }

int draw_text(cv::Mat& picture, const std::string& text, cv::Point left_and_base, double size, int width,
              const cv::Scalar& colour, int weight) {
  const std::string shown = fitted(text, size, width);
  cv::putText(picture, shown, left_and_base, cv::FONT_HERSHEY_SIMPLEX, size, colour, weight, cv::LINE_AA);
  return ascii_width(shown, size);
}

cv::Mat false_colours(const cv::Mat& values, int brightest, ColourScale scale) {
  assert(brightest > 0 && (values.type() == CV_8UC1 || values.type() == CV_16UC1));
  std::vector<std::uint8_t> shades(static_cast<std::size_t>(brightest) + 1);
  for (std::size_t value = 0; value < shades.size(); ++value) {
    const double share = static_cast<double>(value) / brightest;
    shades[value] = static_cast<std::uint8_t>(std::lround(255 * (scale == ColourScale::root ? std::sqrt(share) : share)));
  }
  cv::Mat shaded(values.size(), CV_8UC1), coloured;
  const auto shade = [&](auto value) { return shades[std::min<std::size_t>(value, shades.size() - 1)]; };
  for (int y = 0; y < values.rows; ++y) {
    if (values.depth() == CV_8U)
      std::transform(values.ptr<std::uint8_t>(y), values.ptr<std::uint8_t>(y) + values.cols, shaded.ptr<std::uint8_t>(y), shade);
    else
      std::transform(values.ptr<std::uint16_t>(y), values.ptr<std::uint16_t>(y) + values.cols, shaded.ptr<std::uint8_t>(y),
                     shade);
  }
  cv::applyColorMap(shaded, coloured, cv::COLORMAP_INFERNO);
  return coloured;
}

void draw_colour_bar(cv::Mat& picture, const cv::Rect& place) {
  cv::Mat values(place.size(), CV_8UC1);
  const bool is_wide = place.width > place.height;
  for (int y = 0; y < values.rows; ++y) {
    for (int x = 0; x < values.cols; ++x) {
      const double share = is_wide ? (x + 0.5) / values.cols : (values.rows - y - 0.5) / values.rows;
      values.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(255 * share);
    }
  }
  false_colours(values, 255).copyTo(picture(place));
  cv::rectangle(picture, place, faint_ink);
}

cv::Mat fitted_picture(const cv::Mat& picture, cv::Size size) {
  if (picture.size() == size) return picture.clone();
  if (size.width >= picture.cols && size.height >= picture.rows) {
    cv::Mat larger;
    cv::resize(picture, larger, size, 0, 0, cv::INTER_NEAREST);
    return larger;
  }
  // Where only one side shrinks, the other is enlarged first.
  const cv::Size between(std::max(size.width, picture.cols), std::max(size.height, picture.rows));
  const cv::Mat source = between == picture.size() ? picture : fitted_picture(picture, between);
  cv::Mat smaller(size, picture.type(), cv::Scalar(0));
  picture.depth() == CV_8U ? keep_largest<std::uint8_t>(source, smaller) : keep_largest<std::uint16_t>(source, smaller);
  return smaller;
}

cv::Size shown_size(cv::Size picture, int side) {
  const double scale = static_cast<double>(side) / std::max(picture.width, picture.height);
  if (scale >= 2.0 / 3) return picture * std::max(1, static_cast<int>(std::lround(scale)));
  return {std::max(1, static_cast<int>(std::lround(picture.width * scale))),
          std::max(1, static_cast<int>(std::lround(picture.height * scale)))};
}

}  // namespace tactile::pictures
