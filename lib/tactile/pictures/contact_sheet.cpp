#include "tactile/pictures/contact_sheet.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <string>
#include <tuple>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/pictures/drawing.hpp"
#include "tactile/video/picture_codec.hpp"

namespace tactile::pictures {
namespace {

constexpr int tile_side = 256;

int rows_of(const SheetGroup& group, int columns) { return (static_cast<int>(group.tiles.size()) + columns - 1) / columns; }

void check_tiles(const std::vector<SheetGroup>& groups) {
  const SheetTile* first = nullptr;
  for (const SheetGroup& group : groups) {
    for (const SheetTile& tile : group.tiles) {
      if (first == nullptr) first = &tile;
      const std::array<std::tuple<const cv::Mat*, const cv::Mat*, int>, 3> pictures{{{&tile.counts, &first->counts, CV_16UC1},
                                                                                     {&tile.denoised, &first->denoised, CV_8UC1},
                                                                                     {&tile.heatmap, &first->heatmap, CV_8UC1}}};
      for (const auto& [picture, firsts, type] : pictures) {
        if (picture->empty() || picture->type() != type)
          throw Error("contact sheet: a tile lacks a picture, or has one of another type; expected counts, denoised and heatmap");
        if (picture->size() != firsts->size())
          throw Error("contact sheet: tiles differ in size; expected heatmaps of one sensor");
      }
    }
  }
  if (first == nullptr) throw Error("contact sheet: no tile; expected at least one heatmap");
}

/// The sheet while it is drawn.
class Sheet {
  static constexpr int margin = 24, gap = 14, border = 3, row_gap = 6;
  static constexpr int scale_width = 118;  // of the legend left of the tiles
  static constexpr int header_line = 28, title_line = 34, caption_line = 22;
  static constexpr int narrowest_tile = 220;
  static constexpr double header_size = 0.62, title_size = 0.6, caption_size = 0.5, scale_size = 0.48;
  static constexpr std::int64_t most_pixels = std::int64_t{1} << 28;

 public:
  Sheet(const std::vector<SheetGroup>& groups, const SheetOptions& options) : options_(options) {
    std::size_t most_tiles = 0;
    for (const SheetGroup& group : groups) {
      most_tiles = std::max(most_tiles, group.tiles.size());
      if (!group.tiles.empty()) shown_ = shown_size(group.tiles.front().heatmap.size(), tile_side);
    }
    columns_ = static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(options.columns), most_tiles));
    tile_width_ = std::max(shown_.width, narrowest_tile) + 2 * border;
    picture_height_ = shown_.height + 2 * border;
    block_height_ = 3 * picture_height_ + 2 * row_gap + 2 * caption_line + 10;

    // A sheet of few tiles is still as wide as four, for the sake of its header.
    const int width = 2 * margin + scale_width + std::max(columns_ * (tile_width_ + gap) - gap, 4 * narrowest_tile);
    std::int64_t height = 2 * margin + std::int64_t(options.header.size()) * header_line + gap;
    if (options.banner.draw) height += options.banner.height + gap;
    for (const SheetGroup& group : groups)
      height += (group.title.empty() ? 0 : title_line) + std::int64_t{rows_of(group, columns_)} * (block_height_ + gap);
    if (height * width > most_pixels)
      throw Error(fmt::format("contact sheet: {} x {} pixels; expected fewer tiles", width, height));
    sheet_.create(static_cast<int>(height), width, CV_8UC3);
    sheet_.setTo(paper);
  }

  cv::Mat draw(const std::vector<SheetGroup>& groups) {
    int top = margin;
    for (const std::string& line : options_.header) {
      draw_text(sheet_, line, {margin, top + 18}, header_size, sheet_.cols - 2 * margin, ink);
      top += header_line;
    }
    top += gap;
    if (options_.banner.draw) {
      options_.banner.draw(sheet_, {margin, top, sheet_.cols - 2 * margin, options_.banner.height});
      top += options_.banner.height + gap;
    }
    for (const SheetGroup& group : groups) {
      if (!group.title.empty()) {
        draw_text(sheet_, group.title, {margin, top + 18}, title_size, sheet_.cols - 2 * margin, ink);
        top += title_line;
      }
      for (std::size_t i = 0; i < group.tiles.size(); ++i) {
        const int column = static_cast<int>(i) % columns_, row = static_cast<int>(i) / columns_;
        const int block_top = top + row * (block_height_ + gap);
        if (column == 0) draw_scales(block_top);
        draw_tile(group.tiles[i], {margin + scale_width + column * (tile_width_ + gap), block_top});
      }
      top += rows_of(group, columns_) * (block_height_ + gap);
    }
    return sheet_;
  }

 private:
  /// What the three rows show, and from where to where their colours go.
  void draw_scales(int top) {
    struct Scale {
      std::array<const char*, 2> name;
      int brightest;
    };
    const std::array<Scale, 3> scales{{{{"events", "per pixel"}, options_.brightness.counts},
                                       {{"denoised", "(% of max.)"}, 100},
                                       {{"heatmap", "(of 255)"}, options_.brightness.heatmap}}};
    for (const Scale& scale : scales) {
      int base = top + 16;
      for (const char* line : scale.name) {
        draw_text(sheet_, line, {margin, base}, scale_size, scale_width - 6, ink);
        base += 18;
      }
      const int bar_top = base - 4, bar_bottom = top + picture_height_ - 2;
      if (bar_bottom - bar_top >= 40) {
        draw_colour_bar(sheet_, {margin, bar_top, 14, bar_bottom - bar_top});
        draw_text(sheet_, std::to_string(scale.brightest), {margin + 20, bar_top + 12}, scale_size, scale_width - 26, faint_ink);
        draw_text(sheet_, "0", {margin + 20, bar_bottom}, scale_size, scale_width - 26, faint_ink);
      }
      top += picture_height_ + row_gap;
    }
  }

  void draw_tile(const SheetTile& tile, cv::Point corner) {
    const std::array<cv::Mat, 3> pictures{
        false_colours(fitted_picture(tile.counts, shown_), options_.brightness.counts, ColourScale::root),
        false_colours(fitted_picture(tile.denoised, shown_), 255),
        false_colours(fitted_picture(tile.heatmap, shown_), options_.brightness.heatmap)};
    cv::Point place = corner;
    for (const cv::Mat& picture : pictures) {
      sheet_({place, shown_ + cv::Size(2 * border, 2 * border)}).setTo(touch_colour(tile.touch));
      picture.copyTo(sheet_({place + cv::Point(border, border), shown_}));
      place.y += picture_height_ + row_gap;
    }
    const int base = place.y + 12;
    draw_text(sheet_, tile.caption, {corner.x, base}, caption_size, tile_width_, ink);
    draw_text(sheet_, tile.second_caption, {corner.x, base + caption_line}, caption_size, tile_width_, faint_ink);
  }

  const SheetOptions& options_;
  cv::Size shown_;
  int columns_ = 1, tile_width_ = 0, picture_height_ = 0, block_height_ = 0;
  cv::Mat sheet_;
};

}  // namespace

SheetTile sheet_tile(const Moment& moment) {
  const cv::Size shown = shown_size(moment.heatmap.size(), tile_side);
  const auto kept = [&](const cv::Mat& picture) {
    return fitted_picture(picture, {std::min(shown.width, picture.cols), std::min(shown.height, picture.rows)});
  };
  return {.counts = kept(moment.counts),
          .denoised = kept(moment.denoised),
          .heatmap = kept(moment.heatmap),
          .caption = {},
          .second_caption = {},
          .touch = {}};
}

cv::Mat contact_sheet(const std::vector<SheetGroup>& groups, const SheetOptions& options) {
  check_tiles(groups);
  const Brightness& brightness = options.brightness;
  if (options.columns < 1 || brightness.counts < 1 || brightness.heatmap < 1 || brightness.heatmap > 255) {
    throw Error("contact sheet: layout out of range; expected at least 1 column, 1 event and 1 to 255 as the brightest values");
  }
  return Sheet(groups, options).draw(groups);
}

void write_png(const std::filesystem::path& file, const cv::Mat& picture) {
  const std::vector<unsigned char> bytes = video::png_of(picture, file.string());
  write_whole(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace tactile::pictures
