#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tactile/pictures/gnuplot.hpp"

namespace tactile::test {

/// Whether a table of the figure has this row.
inline bool has_row(const pictures::Plot& plot, const std::vector<double>& row) {
  return std::any_of(plot.tables.begin(), plot.tables.end(), [&](const pictures::PlotTable& table) {
    if (table.columns != row.size()) return false;
    for (std::size_t begin = 0; begin < table.values.size(); begin += table.columns) {
      bool same = true;
      for (std::size_t i = 0; i < row.size(); ++i) same = same && std::abs(table.values[begin + i] - row[i]) < 1e-9;
      if (same) return true;
    }
    return false;
  });
}

inline bool contains(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

}  // namespace tactile::test
