#include "tactile/report/csv_reader.hpp"

#include "tactile/core/whole_file.hpp"

namespace tactile::report {

CsvReader::CsvReader(const std::filesystem::path& file, std::size_t largest) : text_(read_text(file, largest)), rows_(text_) {}

bool CsvReader::has(std::string_view column) const { return rows_.column(column).has_value(); }

bool CsvReader::next() {
  while (rows_.next()) {
    if (!rows_.row().empty()) return true;
  }
  return false;
}

std::optional<std::string_view> CsvReader::operator[](std::string_view column) const {
  const std::optional<std::size_t> index = rows_.column(column);
  return index && *index < rows_.cells().size() ? std::optional(rows_.cells()[*index]) : std::nullopt;
}

}  // namespace tactile::report
