#include "tactile/core/csv_table.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "tactile/core/csv.hpp"

namespace tactile {

std::string csv_number(double number, int digits) { return std::isfinite(number) ? fmt::format("{:.{}g}", number, digits) : ""; }

std::string csv_number(const std::optional<double>& number, int digits) { return number ? csv_number(*number, digits) : ""; }

void CsvCells::add(std::string_view text) {
  if (count_++ > 0) text_ += ',';
  text_ += csv_cell(text);
}

void CsvCells::add(std::span<const std::string> texts) {
  for (const std::string& text : texts) add(std::string_view(text));
}

CsvTable::CsvTable(std::string_view columns)
    : columns_(1 + static_cast<std::size_t>(std::count(columns.begin(), columns.end(), ','))), text_(columns) {
  text_ += '\n';
}

void CsvTable::add(const CsvCells& row) {
  assert(row.count() == columns_ && "a row has a cell for each column");
  text_ += row.text();
  text_ += '\n';
}

}  // namespace tactile
