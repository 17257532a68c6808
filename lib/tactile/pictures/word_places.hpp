#pragma once

#include <vector>

#include "tactile/pictures/plot_script.hpp"

namespace tactile::pictures {

/// Finds places for words next to the marks of a panel, where they cover as little as possible. All in pixels from the figure's
/// top left corner; a line of words is taken to be 16 px high, as at 10 or 11 points.
class WordPlaces {
 public:
  explicit WordPlaces(const PlotBox& panel) : panel_(panel) {}

  /// A mark or a line covers this place.
  void take(double left, double top, double right, double bottom) { taken_.push_back({left, top, right, bottom}); }

  struct Place {
    double x = 0, y = 0;    ///< its middle
    double width = 0;       ///< of the words
    bool is_beside = true;  ///< else so far away that a line must join them to their mark
    bool is_free = true;    ///< they cover nothing
    bool covers_words = false;

    /// They are read as those of the mark, with no line.
    bool is_plain() const { return is_free && is_beside; }
  };

  /// The best place near (x, y) for a line of this width, within the panel: as close as one is free, at most some 120 px off.
  /// Of a point that is not finite, or where the panel is too small, one that is neither free nor next to the mark.
  Place near(double x, double y, double width) const;

  /// A thin line covers this place.
  void take_line(double x, double y, double to_x, double to_y);

  /// Words cover this place: others avoid it most.
  void take(const Place& place);

 private:
  struct Box {
    double left = 0, top = 0, right = 0, bottom = 0;
    bool is_words = false;
  };
  /// The area under the box that is taken already, in square pixels; words count most.
  double covered_by(const Box& box) const;
  bool meets_words(const Box& box) const;
  bool line_meets_words(double x, double y, const Box& box) const;

  PlotBox panel_;
  std::vector<Box> taken_;
};

}  // namespace tactile::pictures
