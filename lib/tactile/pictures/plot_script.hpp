#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/pictures/plot_head.hpp"

namespace tactile::pictures {

/// One of eight that differ without colours too. @param index  taken modulo 8
LineStyle line_style(std::size_t index);

/// An axis of a panel.
struct PlotAxis {
  double begin = 0, end = 1;
  std::string_view label = {};
  std::string tics = {};            ///< gnuplot's list, "'none' -1, '1' 0"; empty: gnuplot chooses
  std::string_view tic_style = {};  ///< gnuplot's: "scale 0"; used with `tics`
  bool has_labels = true;           ///< at its tics
};

/// A curve, marks or bars of a table.
struct PlotSeries {
  std::string table;         ///< as `PlotScript::table` names it
  std::string_view columns;  ///< of the table: "1:2"
  std::string_view with;     ///< gnuplot's style: "lines", "yerrorbars"
  LineStyle style;
};

/// A figure of results in the making: its head, and panels with axes and series.
class PlotScript : public PlotWriter {
 public:
  PlotScript(PlotHead head, int height_px);

  /// The next `plot` draws into this place. Settings and words of the panels before are forgotten.
  void begin_panel(const PlotBox& box);

  /// The axes of the panel.
  void axes(const PlotAxis& x, const PlotAxis& y);

  /// Draws the panel.
  void plot(const std::vector<PlotSeries>& series);

  /// Words at a place in pixels, drawn with the next panel. `style` is gnuplot's: "center font ',12'".
  void text(std::string_view words, double x, double y, std::string_view style, std::string_view colour = figure_colours::ink);

  /// A line between two places in pixels, drawn with the panel at hand.
  void line(double x, double y, double to_x, double to_y, std::string_view colour, double width, int dashes = 1);

 private:
  void axis(char name, const PlotAxis& axis);

  PlotHead head_;
  bool drawn_ = false;  ///< a panel has been begun
};

}  // namespace tactile::pictures
