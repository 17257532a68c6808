#include "tactile/report/contact_sheet.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

constexpr int margin = 24, gap = 14, border = 3;
constexpr int header_line = 28, title_line = 34, caption_line = 20;
constexpr int narrowest_tile = 200;
constexpr double header_size = 0.6, title_size = 0.55, caption_size = 0.45;
const cv::Scalar paper{255, 255, 255}, ink{40, 40, 40}, faint_ink{90, 90, 90};

cv::Scalar frame_colour(const std::optional<Touch>& touch) {
  if (touch == Touch::press) return {200, 90, 0};  // blue
  if (touch == Touch::slip) return {0, 90, 230};   // orange
  return {170, 170, 170};
}

int width_of(const std::string& text, double size) {
  int below = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &below).width;
}

/// The fonts draw nothing else.
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

std::string fitted(const std::string& text, double size, int width) {
  const std::string ascii = as_ascii(text);
  if (width_of(ascii, size) <= width) return ascii;
  for (std::size_t kept = ascii.size(); kept-- > 0;) {
    const std::string shorter = ascii.substr(0, (kept + 1) / 2) + "..." + ascii.substr(ascii.size() - kept / 2);
    if (width_of(shorter, size) <= width) return shorter;
  }
  return {};
}

void write_text(cv::Mat& sheet, const std::string& text, cv::Point left_and_base, double size, int width,
                const cv::Scalar& colour) {
  cv::putText(sheet, fitted(text, size, width), left_and_base, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

int rows_of(const SheetGroup& group, int columns) { return (static_cast<int>(group.tiles.size()) + columns - 1) / columns; }

void check_tiles(const std::vector<SheetGroup>& groups) {
  cv::Size size;
  for (const SheetGroup& group : groups) {
    for (const SheetTile& tile : group.tiles) {
      if (tile.heatmap.empty() || tile.heatmap.type() != CV_8UC1)
        throw Error("contact sheet: a tile is no picture of grey bytes; expected heatmaps");
      if (size.empty()) size = tile.heatmap.size();
      if (tile.heatmap.size() != size) throw Error("contact sheet: tiles differ in size; expected heatmaps of one sensor");
    }
  }
  if (size.empty()) throw Error("contact sheet: no tile; expected at least one heatmap");
}

}  // namespace

cv::Mat contact_sheet(const std::vector<SheetGroup>& groups, const SheetOptions& options) {
  check_tiles(groups);
  if (options.columns < 1 || options.scale < 0 || options.brightest < 1 || options.brightest > 255) {
    throw Error(
        "contact sheet: layout out of range; expected at least 1 column, a scale of 0 or more, and 1 to 255 as the brightest "
        "value");
  }
  std::size_t most_tiles = 0;
  cv::Size heatmap;
  for (const SheetGroup& group : groups) {
    most_tiles = std::max(most_tiles, group.tiles.size());
    if (!group.tiles.empty()) heatmap = group.tiles.front().heatmap.size();
  }
  const int columns = static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(options.columns), most_tiles));
  const int scale = options.scale > 0 ? options.scale : std::max(1, (narrowest_tile + heatmap.width - 1) / heatmap.width);
  const cv::Size picture = heatmap * scale;
  const int tile_width = std::max(picture.width, narrowest_tile) + 2 * border;
  const int tile_height = picture.height + 2 * border + 2 * caption_line + 8;

  // A sheet of few tiles is still as wide as four, for the sake of its header.
  const int width = 2 * margin + std::max(columns * (tile_width + gap) - gap, 4 * narrowest_tile);
  int height = 2 * margin + static_cast<int>(options.header.size()) * header_line + gap;
  for (const SheetGroup& group : groups) {
    height += (group.title.empty() ? 0 : title_line) + rows_of(group, columns) * (tile_height + gap);
  }
  cv::Mat sheet(height, width, CV_8UC3, paper);

  int top = margin;
  for (const std::string& line : options.header) {
    write_text(sheet, line, {margin, top + 18}, header_size, width - 2 * margin, ink);
    top += header_line;
  }
  top += gap;
  for (const SheetGroup& group : groups) {
    if (!group.title.empty()) {
      write_text(sheet, group.title, {margin, top + 16}, title_size, width - 2 * margin, ink);
      top += title_line;
    }
    for (std::size_t i = 0; i < group.tiles.size(); ++i) {
      const SheetTile& tile = group.tiles[i];
      const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
      const cv::Point corner(margin + column * (tile_width + gap), top + row * (tile_height + gap));
      const cv::Rect framed(corner, picture + cv::Size(2 * border, 2 * border));
      cv::Mat stretched, enlarged, coloured;
      tile.heatmap.convertTo(stretched, CV_8U, 255.0 / options.brightest);
      cv::resize(stretched, enlarged, picture, 0, 0, cv::INTER_NEAREST);
      cv::applyColorMap(enlarged, coloured, cv::COLORMAP_INFERNO);
      sheet(framed).setTo(frame_colour(tile.touch));
      coloured.copyTo(sheet({corner + cv::Point(border, border), picture}));
      const int base = framed.br().y + 16;
      write_text(sheet, tile.caption, {corner.x, base}, caption_size, tile_width, ink);
      write_text(sheet, tile.second_caption, {corner.x, base + caption_line}, caption_size, tile_width, faint_ink);
    }
    top += rows_of(group, columns) * (tile_height + gap);
  }
  return sheet;
}

void write_png(const std::filesystem::path& file, const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", picture, bytes))
    throw Error(file.string() + ": cannot be made a PNG; expected a picture of grey or BGR bytes");
  write_whole(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace tactile
