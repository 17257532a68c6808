#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/pictures/plot_writer.hpp"

namespace tactile::pictures {

/// Of a curve, marks or bars; dashes and marks by gnuplot's numbers.
struct LineStyle {
  std::string_view colour;
  double width = 1;              ///< of lines; in a key, 0: no line
  int dashes = 1;                ///< 1: solid
  std::optional<int> mark = {};  ///< nothing: no marks
  double size = 1;               ///< of marks
  double fill = 0;               ///< of boxes, in [0, 1]; 0: not filled
};

/// `text` in at most `characters` of UTF-8; what is longer loses its middle. @param characters  > 0
std::string shortened(std::string_view text, std::size_t characters);

/// What stands over the panels of a figure, one below the other: the title, the key, words. Each takes as many rows as the width
/// of the figure needs.
class PlotHead {
 public:
  /// @param title  in at most two rows; a longer one loses its middle
  PlotHead(std::string_view title, int width_px);

  /// A sample of a line with its mark, or of an area where `style` is filled, and what it stands for.
  void key(const std::string& words, const LineStyle& style);
  void note(const std::string& words);  ///< empty: nothing is added

  int width_px() const { return width_px_; }
  int bottom() const { return bottom_; }  ///< [px] from the top of the figure; the next panel begins below

  /// Adds the commands, for the first panel.
  void write(PlotWriter& writer) const;

 private:
  struct Entry {
    std::string words;
    int x = 0, y = 0;  ///< [px], the middle of its left side
    LineStyle style;
  };
  struct Line {
    std::string words;
    int y = 0;
  };
  int width_px_, bottom_ = 0, next_x_ = 0;
  std::vector<Line> title_, notes_;
  std::vector<Entry> keys_;
};

}  // namespace tactile::pictures
