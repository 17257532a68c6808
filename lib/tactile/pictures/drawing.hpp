#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "tactile/core/touch.hpp"

// What pictures of heatmaps are drawn with. Pictures are [height, width] BGR of 8 bits.
namespace tactile::pictures {

inline const cv::Scalar paper{255, 255, 255}, ink{40, 40, 40}, faint_ink{90, 90, 90};

/// Blue for press and orange for slip, which differ for every kind of colour vision; grey for none and without a label.
cv::Scalar touch_colour(const std::optional<Touch>& touch);
cv::Scalar light_touch_colour(Touch touch);  ///< the same, for areas that something is drawn over

/// How wide a text is as `draw_text` draws it [px].
int text_width(const std::string& text, double size);

/// Writes a line, from its left end on the base line. One that is wider than `width` is shortened in its middle, so nothing is
/// clipped; characters other than ASCII, which the font lacks, are shown as '?'.
/// @param size    1 gives capitals of 21 px
/// @param weight  of the strokes [px]
/// @return        how wide it became [px]
int draw_text(cv::Mat& picture, const std::string& text, cv::Point left_and_base, double size, int width,
              const cv::Scalar& colour, int weight = 1);

/// How values become colours: in proportion, or by their square root, so that single events are visible next to many.
enum class ColourScale : std::uint8_t { linear, root };

/// False colours from black (0) over red and yellow to nearly white (`brightest` and above), ever lighter, so
/// that their order is seen without telling the colours apart.
///
/// @param values     [height, width] uint8 or uint16
/// @param brightest  > 0
cv::Mat false_colours(const cv::Mat& values, int brightest, ColourScale scale = ColourScale::linear);

/// The colours of `false_colours` from dark to light: from left to right if it is wider than high, else from the bottom upwards.
void draw_colour_bar(cv::Mat& picture, const cv::Rect& place);

/// A picture in another size, without new values: enlarged, each pixel repeats the nearest; made smaller, each is the largest of
/// those it stands for, so that what a single pixel saw is still seen.
/// @param picture  [height, width] uint8 or uint16, not empty
cv::Mat fitted_picture(const cv::Mat& picture, cv::Size size);

/// The size closest to `side` pixels along its longer side that shows each pixel of `picture` as a square of whole pixels; a
/// picture that is itself larger than 1.5 times the side is made smaller instead.
cv::Size shown_size(cv::Size picture, int side);

}  // namespace tactile::pictures
