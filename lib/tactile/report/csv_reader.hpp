#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "tactile/core/csv.hpp"

namespace tactile::report {

/// Reads a CSV file row by row, its fields by the names of their columns. The first line names the columns. Quotes have no
/// meaning, lines may end with "\r\n", and empty lines are skipped.
class CsvReader {
 public:
  /// @param largest  [B]
  /// @throws Error   if the file cannot be read or is larger
  CsvReader(const std::filesystem::path& file, std::size_t largest);
  CsvReader(const CsvReader&) = delete;  // fields are views into the text
  CsvReader& operator=(const CsvReader&) = delete;

  bool has(std::string_view column) const;

  /// Goes to the next row. @return  whether there is one
  bool next();

  /// A field of this row; nothing where there is no such column, or the row is too short.
  std::optional<std::string_view> operator[](std::string_view column) const;

  std::size_t line() const { return rows_.line(); }  ///< of the file, from 1

 private:
  std::string text_;
  CsvRows rows_;
};

}  // namespace tactile::report
