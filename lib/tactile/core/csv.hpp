#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactile {

/// The cells of a row, as views into it; an empty row has one empty cell. @param row  without quotes and line end
inline std::vector<std::string_view> split_cells(std::string_view row, char separator = ',') {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(row.find(separator, begin), row.size());
    cells.push_back(row.substr(begin, end - begin));
    if (end == row.size()) return cells;
    begin = end + 1;
  }
}

/// `text` as a cell for any spreadsheet: in quotes if it contains a separator, a quote or a line end.
inline std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",;\t\"\r\n") == std::string_view::npos) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

/// Reads the rows of a table of comma-separated values without quotes. The first row names the columns. Lines end in LF or CR LF.
class CsvRows {
 public:
  /// Reads the first row. @param text  must outlive this
  explicit CsvRows(std::string_view text) : rest_(text) {
    next();
    names_ = cells_;
    line_ = 1;  // also of an empty text
  }

  /// Advances to the next row. @return  false at the end of the text
  bool next() {
    if (rest_.empty()) return false;
    ++line_;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    row_ = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    if (row_.ends_with('\r')) row_.remove_suffix(1);
    cells_ = split_cells(row_);
    return true;
  }

  std::optional<std::size_t> column(std::string_view name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    return found == names_.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - names_.begin()));
  }
  std::string_view row() const { return row_; }
  const std::vector<std::string_view>& cells() const { return cells_; }
  std::size_t line() const { return line_; }  ///< number of the row's line, from 1

 private:
  std::string_view rest_, row_;
  std::vector<std::string_view> names_, cells_;
  std::size_t line_ = 0;
};

}  // namespace tactile
