#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"

namespace tactile {

/// One small picture of a contact sheet.
struct SheetTile {
  cv::Mat heatmap;      ///< [height, width] uint8, not empty; all tiles of a sheet have one size
  std::string caption;  ///< under it, in two lines
  std::string second_caption;
  std::optional<Touch> touch;  ///< colours its frame
};

/// Tiles that belong together, laid out in rows under a title.
struct SheetGroup {
  std::string title;  ///< may be empty
  std::vector<SheetTile> tiles;
};

struct SheetOptions {
  std::vector<std::string> header;  ///< lines at the top; the first is the title
  int columns = 6;                  ///< >= 1
  int brightest = 255;              ///< heatmap value shown in the brightest colour, as are those above it; 1 to 255
  int scale = 0;                    ///< screen pixels to a heatmap pixel; 0: so that a tile is about 200 wide
};

/// Lays heatmaps out as one picture: black 0 to white 255 over red and yellow, each pixel enlarged without smoothing. Text that
/// is too long for its place is shortened in its middle, so nothing is clipped; characters other than ASCII are shown as '?'.
///
/// @return  [height, width] BGR of 8 bits
/// @throws Error  if there is no tile, the tiles differ in size or type, or an option is out of its range
cv::Mat contact_sheet(const std::vector<SheetGroup>& groups, const SheetOptions& options = {});

/// Writes a picture as PNG, whole or not at all. @throws Error if it cannot be written
void write_png(const std::filesystem::path& file, const cv::Mat& picture);

}  // namespace tactile
