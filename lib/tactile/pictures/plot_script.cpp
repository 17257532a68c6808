#include "tactile/pictures/plot_script.hpp"

#include <algorithm>
#include <array>

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

std::string shortened(std::string_view text, std::size_t characters) {
  if (characters_in(text) <= characters) return std::string(text);
  // Where characters begin.
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U) begins.push_back(i);
  }
  if (begins.size() <= characters) return std::string(text);
  const std::size_t kept = characters - 1, front = (kept + 1) / 2, back = kept / 2;
  const std::size_t front_end = begins[front];
  const std::size_t back_begin = back == 0 ? text.size() : begins[begins.size() - back];
  return std::string(text.substr(0, front_end)) + "…" + std::string(text.substr(back_begin));
}

PlotScript::PlotScript(std::string_view title, int width_px, int height_px) : PlotWriter(width_px, height_px) {
  constexpr double title_character = 10.8;  // [px] of the title's letters, on average of wide ones
  add("set termoption font 'DejaVu Sans,12'");
  add("set multiplot");
  add("set border 3 lc rgb '{}' lw 0.8", figure_colours::faint_ink);
  add("set tics nomirror scale 0.5 textcolor rgb '{}' font ',11'", figure_colours::ink);
  add("set errorbars small");
  text(shortened(title, static_cast<std::size_t>(std::max(20.0, (width_px - 40) / title_character))), 20, 24, "left font ',15'");
}

void PlotScript::begin_panel(const PlotBox& box) {
  if (drawn_) add("unset label");
  drawn_ = true;
  add("unset object\nunset arrow\nunset xlabel\nunset ylabel\nunset title\nunset key\nunset grid\nunset logscale");
  add("set grid x y lt 1 lc rgb '{}' lw 0.6", figure_colours::grid);
  add("set xtics autofreq rotate by 0\nset ytics autofreq\nset format x '%g'\nset format y '%g'");
  add("set xrange [*:*]\nset yrange [*:*]");
  place_panel(box);
}

void PlotScript::note(std::string_view words) {
  constexpr int left = 20, first = 52, row = 20;  // [px]
  text(words, left, first + row * notes_++, "left font ',12'", figure_colours::faint_ink);
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
