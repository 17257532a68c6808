#pragma once

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "evaluation/trained_model.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::test {

/// A row of a table of ticks, by the names of its columns.
using TickRow = std::map<std::string, std::string>;

inline std::vector<TickRow> rows_of(const std::filesystem::path& file) {
  std::istringstream text(read_text(file));
  std::vector<std::string> header;
  std::vector<TickRow> rows;
  for (std::string line; std::getline(text, line);) {
    std::istringstream cells(line);
    std::vector<std::string> values;
    for (std::string cell; std::getline(cells, cell, ',');) values.push_back(cell);
    if (header.empty()) {
      header = values;
      continue;
    }
    TickRow& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(values.size(), header.size()); ++i) row[header[i]] = values[i];
  }
  return rows;
}

/// What has a model takes a while to make: all tests share one.
inline const Trained& trained() {
  static const Trained shared;
  return shared;
}

}  // namespace tactile::test
