#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/pictures/gnuplot.hpp"
#include "tactile/pictures/thinned.hpp"

namespace tactile::pictures {

/// Colours of figures. Press and slip differ for every kind of colour vision, and in brightness. All other lines also
/// differ by dashes or marks.
/// Source: Okabe and Ito, Color Universal Design, 2008.
namespace figure_colours {
inline constexpr std::string_view paper = "#FFFFFF", ink = "#303030", faint_ink = "#707070", grid = "#E6E6E6";
inline constexpr std::string_view press = "#005AC8", slip = "#E65A00", others = "#C4C4C4", network = "#005AC8", best = "#E65A00";
std::string_view of(Touch touch);

/// Of an interval: of its area, of the uncertainty of its ends, and of its onset.
struct IntervalColours {
  std::string_view area, border, strong;
};
IntervalColours of_interval(Touch touch);  ///< press or slip
}  // namespace figure_colours

/// A place in a figure, in pixels from its top left corner.
struct PlotBox {
  int left = 0, top = 0, right = 0, bottom = 0;
};

/// Writes a figure as commands of gnuplot: words at places in pixels, bands and lines over a panel, numbers as tables.
class PlotWriter {
 public:
  PlotWriter() = default;
  PlotWriter(int width_px, int height_px) { resize(width_px, height_px); }

  /// Before anything is placed in pixels.
  void resize(int width_px, int height_px);
  int width_px() const { return plot_.width_px; }
  int height_px() const { return plot_.height_px; }

  /// Adds a command.
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(plot_.script), format, std::forward<Values>(values)...);
    plot_.script += '\n';
  }

  /// Words at a place in pixels, drawn with the next `plot` command. `style` is gnuplot's: "center font ',12'".
  void write(std::string_view words, double x, double y, std::string_view style, std::string_view colour);

  /// The place of the next panel.
  void place_panel(const PlotBox& box);

  /// A band over the height of the panel, between two places of its x axis.
  void band(double from, double to, std::string_view colour);

  /// A line over the height of the panel. `style` is gnuplot's: "lc rgb 'black' lw 1.2".
  void upright(double x, std::string_view style);

  /// Numbers as a table; its name, "$t0". Without values a row of gaps, since gnuplot takes no table without rows.
  std::string table(std::size_t columns, std::vector<double> values);
  std::string table(std::span<const PlotPoint> points);

  Plot finished() && { return std::move(plot_); }

 private:
  Plot plot_;
};

}  // namespace tactile::pictures
