#include "tactile/pictures/plot_script.hpp"

#include <array>
#include <utility>

#include "tactile/core/text_lines.hpp"

namespace tactile::pictures {

LineStyle line_style(std::size_t index) {
  struct Style {
    std::string_view colour;
    int dashes, mark;
  };
  static constexpr std::array<Style, 8> styles{{{"#005AC8", 1, 7},
                                                {"#E65A00", 2, 5},
                                                {"#009E73", 3, 9},
                                                {"#CC79A7", 4, 13},
                                                {"#56B4E9", 5, 6},
                                                {"#B8860B", 1, 4},
                                                {"#303030", 2, 8},
                                                {"#7B3294", 3, 12}}};
  const Style& style = styles[index % styles.size()];
  return {.colour = style.colour, .width = 1.6, .dashes = style.dashes, .mark = style.mark, .size = 0.8};
}

PlotScript::PlotScript(PlotHead head, int height_px) : PlotWriter(head.width_px(), height_px), head_(std::move(head)) {
  add("set termoption font 'DejaVu Sans,12'");
  add("set multiplot");
  add("set border 3 lc rgb '{}' lw 0.8", figure_colours::faint_ink);
  add("set tics nomirror scale 0.5 textcolor rgb '{}' font ',11'", figure_colours::ink);
  add("set errorbars small");
}

void PlotScript::begin_panel(const PlotBox& box) {
  if (drawn_) add("unset label");
  add("unset object\nunset arrow\nunset xlabel\nunset ylabel\nunset title\nunset key\nunset grid\nunset logscale");
  if (!drawn_) head_.write(*this);
  drawn_ = true;
  add("set grid x y lt 1 lc rgb '{}' lw 0.6", figure_colours::grid);
  add("set xtics autofreq rotate by 0\nset ytics autofreq\nset format x '%g'\nset format y '%g'");
  add("set xrange [*:*]\nset yrange [*:*]");
  place_panel(box);
}

void PlotScript::axes(const PlotAxis& x, const PlotAxis& y) {
  axis('x', x);
  axis('y', y);
}

void PlotScript::axis(char name, const PlotAxis& axis) {
  add("set {}range [{:.9g}:{:.9g}]", name, axis.begin, axis.end);
  if (!axis.tics.empty()) add("set {}tics {} ({})", name, axis.tic_style, axis.tics);
  if (!axis.has_labels) add("set format {} ''", name);
  if (!axis.label.empty()) add("set {}label {} textcolor rgb '{}'", name, plot_text(axis.label), figure_colours::ink);
}

void PlotScript::plot(const std::vector<PlotSeries>& series) {
  std::string text;
  for (const PlotSeries& one : series) {
    text += fmt::format("{}{} using {} with {}", text.empty() ? "" : ", ", one.table, one.columns, one.with);
    const LineStyle& style = one.style;
    if (style.fill > 0) text += fmt::format(" fs solid {:g} noborder", style.fill);
    text += fmt::format(" lc rgb '{}' lw {:g} dt {}", style.colour, style.width, style.dashes);
    if (style.mark) text += fmt::format(" pt {} ps {:g}", *style.mark, style.size);
    text += " notitle";
  }
  add("plot {}", text);
}

void PlotScript::line(double x, double y, double to_x, double to_y, std::string_view colour, double width, int dashes) {
  add("set arrow from screen {:.6f}, screen {:.6f} to screen {:.6f}, screen {:.6f} nohead lc rgb '{}' dt {} lw {:g}",
      x / width_px(), 1 - y / height_px(), to_x / width_px(), 1 - to_y / height_px(), colour, dashes, width);
}

void PlotScript::text(std::string_view words, double x, double y, std::string_view style, std::string_view colour) {
  write(words, x, y, fmt::format("{} front", style), colour);
}

}  // namespace tactile::pictures
