#include "tactile/report/plot_script.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "tactile/core/text_lines.hpp"

namespace tactile {

std::string_view figure_colours::of(Touch touch) {
  return touch == Touch::press ? press : touch == Touch::slip ? slip : faint_ink;
}

LineStyle line_style(std::size_t index) {
  static constexpr std::array<LineStyle, 8> styles{{{"#005AC8", 1, 7},
                                                    {"#E65A00", 2, 5},
                                                    {"#009E73", 3, 9},
                                                    {"#CC79A7", 4, 13},
                                                    {"#56B4E9", 5, 6},
                                                    {"#B8860B", 1, 4},
                                                    {"#303030", 2, 8},
                                                    {"#7B3294", 3, 12}}};
  return styles[index % styles.size()];
}

std::string shortened(std::string_view text, std::size_t characters) {
  if (characters_in(text) <= characters) return std::string(text);
  // Where characters begin.
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U) begins.push_back(i);
  }
  if (begins.size() <= characters) return std::string(text);
  const std::size_t kept = characters - 1, front = (kept + 1) / 2, behind = kept / 2;
  const std::size_t front_end = begins[front];
  const std::size_t behind_begin = behind == 0 ? text.size() : begins[begins.size() - behind];
  return std::string(text.substr(0, front_end)) + "…" + std::string(text.substr(behind_begin));
}

PlotScript::PlotScript(std::string_view title, int width_px, int height_px) {
  constexpr double title_character = 10;  // [px] of the title's letters, on average
  plot_.width_px = width_px;
  plot_.height_px = height_px;
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
  add("set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}", static_cast<double>(box.left) / plot_.width_px,
      static_cast<double>(box.right) / plot_.width_px);
  add("set tmargin at screen {:.6f}\nset bmargin at screen {:.6f}", 1 - static_cast<double>(box.top) / plot_.height_px,
      1 - static_cast<double>(box.bottom) / plot_.height_px);
}

void PlotScript::text(std::string_view words, double x, double y, std::string_view style, std::string_view colour) {
  add("set label {} at screen {:.6f}, screen {:.6f} {} textcolor rgb '{}' front", plot_text(words), x / plot_.width_px,
      1 - y / plot_.height_px, style, colour);
}

std::string PlotScript::table(std::size_t columns, std::vector<double> values) {
  if (values.empty()) values.assign(columns, std::numeric_limits<double>::quiet_NaN());
  plot_.tables.push_back({.name = fmt::format("t{}", plot_.tables.size()), .columns = columns, .values = std::move(values)});
  return "$" + plot_.tables.back().name;
}

}  // namespace tactile
