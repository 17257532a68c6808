#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/pictures/moments.hpp"

namespace tactile::pictures {

/// A moment on a contact sheet: three pictures one below the other, and two lines of text under them.
struct SheetTile {
  cv::Mat counts;    ///< [height, width] uint16, events per pixel
  cv::Mat denoised;  ///< [height, width] uint8, 255 D / max D
  cv::Mat heatmap;   ///< [height, width] uint8; all tiles of a sheet have one size
  std::string caption;
  std::string second_caption;
  std::optional<Touch> touch;  ///< colours its frames
};

/// Tiles that belong together, laid out in rows under a title.
struct SheetGroup {
  std::string title;  ///< may be empty
  std::vector<SheetTile> tiles;
};

/// A picture between header and tiles, with the width of the sheet.
struct SheetBanner {
  int height = 0;  ///< [px]
  std::function<void(cv::Mat& picture, const cv::Rect& place)> draw = {};
};

struct SheetOptions {
  std::vector<std::string> header = {};  ///< lines at the top; the first is the title
  int columns = 6;                       ///< >= 1
  Brightness brightness{};               ///< values from here on have the brightest colour: counts >= 1, heatmap 1 to 255
  SheetBanner banner{};                  ///< may be empty
};

/// The tile of a moment, its pictures no larger than they are shown, so that many of them are little memory.
SheetTile sheet_tile(const Moment& moment);

/// Lays moments out as one picture: the events per pixel (by the root of their number), the denoised picture and the heatmap,
/// each in false colours without smoothing and with its scale. A tile is about 256 px wide. Text that is too long for its place
/// is shortened in its middle, so nothing is clipped; characters other than ASCII are shown as '?'.
///
/// @return  [height, width] BGR of 8 bits
/// @throws Error  if there is no tile, a tile's pictures lack or differ in size or type, an option is out of its range, or the
///                sheet would have more than 2^28 pixels
cv::Mat contact_sheet(const std::vector<SheetGroup>& groups, const SheetOptions& options = {});

/// Writes a picture as PNG, whole or not at all. @throws Error if it cannot be written
void write_png(const std::filesystem::path& file, const cv::Mat& picture);

}  // namespace tactile::pictures
