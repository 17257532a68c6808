#include "tactile/pictures/plot_writer.hpp"

#include <limits>

namespace tactile::pictures {

std::string_view figure_colours::of(Touch touch) {
  return touch == Touch::press ? press : touch == Touch::slip ? slip : faint_ink;
}

figure_colours::IntervalColours figure_colours::of_interval(Touch touch) {
  return touch == Touch::press ? IntervalColours{"#DCE8F8", "#8DB4EA", press} : IntervalColours{"#FCE6D6", "#F4AE80", slip};
}

void PlotWriter::resize(int width_px, int height_px) {
  plot_.width_px = width_px;
  plot_.height_px = height_px;
}

void PlotWriter::write(std::string_view words, double x, double y, std::string_view style, std::string_view colour) {
  add("set label {} at screen {:.6f}, screen {:.6f} {} textcolor rgb '{}'", plot_text(words), x / plot_.width_px,
      1 - y / plot_.height_px, style, colour);
}

void PlotWriter::place_panel(const PlotBox& box) {
  add("set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}", static_cast<double>(box.left) / plot_.width_px,
      static_cast<double>(box.right) / plot_.width_px);
  add("set tmargin at screen {:.6f}\nset bmargin at screen {:.6f}", 1 - static_cast<double>(box.top) / plot_.height_px,
      1 - static_cast<double>(box.bottom) / plot_.height_px);
}

void PlotWriter::band(double from, double to, std::string_view colour) {
  add("set object rectangle from first {:.9g}, graph 0 to first {:.9g}, graph 1 fillcolor rgb '{}' fillstyle solid noborder "
      "behind",
      from, to, colour);
}

void PlotWriter::upright(double x, std::string_view style) {
  add("set arrow from first {0:.9g}, graph 0 to first {0:.9g}, graph 1 nohead {1}", x, style);
}

std::string PlotWriter::table(std::size_t columns, std::vector<double> values) {
  if (values.empty()) values.assign(columns, std::numeric_limits<double>::quiet_NaN());
  plot_.tables.push_back({.name = fmt::format("t{}", plot_.tables.size()), .columns = columns, .values = std::move(values)});
  return "$" + plot_.tables.back().name;
}

std::string PlotWriter::table(std::span<const PlotPoint> points) {
  std::vector<double> values;
  values.reserve(2 * points.size());
  for (const PlotPoint& point : points) values.insert(values.end(), {point.x, point.y});
  return table(2, std::move(values));
}

}  // namespace tactile::pictures
