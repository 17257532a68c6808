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
#include "tactile/report/gnuplot.hpp"

namespace tactile {

/// Colours of figures of results. Press and slip differ for every kind of colour vision, in brightness too; whatever else tells
/// lines apart does so by dashes or marks as well.
/// Source: Okabe and Ito, Color Universal Design, 2008.
namespace figure_colours {
inline constexpr std::string_view ink = "#303030", faint_ink = "#707070", grid = "#E6E6E6", paper_line = "#8A2BE2";
inline constexpr std::string_view press = "#005AC8", slip = "#E65A00", others = "#C4C4C4", network = "#005AC8", best = "#E65A00";
std::string_view of(Touch touch);
}  // namespace figure_colours

/// A line's colour, its dashes and the mark at its points, in gnuplot's numbers.
struct LineStyle {
  std::string_view colour;
  int dashes = 1;
  int mark = 7;
};

/// Eight that are told apart without colours too. @throws nothing: `index` is taken modulo 8
LineStyle line_style(std::size_t index);

/// `text` in at most `characters` of UTF-8; what is longer loses its middle. @param characters  > 0
std::string shortened(std::string_view text, std::size_t characters);

/// A place in a figure, in pixels from its top left corner.
struct PlotBox {
  int left = 0, top = 0, right = 0, bottom = 0;
};

/// A figure of results in the making: panels at places in pixels, words in any place, numbers as tables.
class PlotScript {
 public:
  /// @param title  told over it; what is longer than the figure is wide loses its middle
  PlotScript(std::string_view title, int width_px, int height_px);

  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(plot_.script), format, std::forward<Values>(values)...);
    plot_.script += '\n';
  }

  /// The next `plot` draws into this place; what panels before it set is forgotten. Words placed before go with it.
  void begin_panel(const PlotBox& box);

  /// Words at a place in pixels, from the next panel on until the one behind it. `style` is gnuplot's: "center font ',12'".
  void text(std::string_view words, double x, double y, std::string_view style, std::string_view colour = figure_colours::ink);

  /// Numbers as a table; its name, "$t0". Without values a row of gaps, since gnuplot takes no table without rows.
  std::string table(std::size_t columns, std::vector<double> values);

  Plot plot() && { return std::move(plot_); }

 private:
  Plot plot_;
  bool drawn_ = false;  ///< a panel has been begun
};

}  // namespace tactile
