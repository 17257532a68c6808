#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactile {

/// The cells of a row, as views into it; an empty row has one empty cell. @param row  without quotes and line end
std::vector<std::string_view> split_cells(std::string_view row, char separator = ',');

/// The same without blanks and quotes around a cell. Several blanks separate like one. A blank row has no cells.
void split_cells(std::string_view row, char separator, std::vector<std::string_view>& cells);

/// The most frequent of comma, semicolon and tab outside quotes, else a blank, else a comma. @param header  the first row
char separator_of(std::string_view header);

/// `text` as a cell for any spreadsheet: in quotes if it contains a separator, a quote or a line end.
std::string csv_cell(std::string_view text);

/// How a table is written.
struct CsvDialect {
  char separator = ',';
  bool has_quotes = false;  ///< a cell in quotes may contain separators, line ends and doubled quotes
};

/// Reads the rows of a table that is in memory. The first row names the columns. Lines end in LF or CR LF.
class CsvRows {
 public:
  /// Reads the first row. @param text  must outlive this
  explicit CsvRows(std::string_view text, CsvDialect dialect = {});

  /// Advances to the next row. @return  false at the end of the text
  bool next();

  /// Advances to the next row that is not empty.
  bool next_filled();

  std::optional<std::size_t> column(std::string_view name) const;

  /// The cell in this column; nothing where there is no such column, or the row is too short.
  std::optional<std::string_view> operator[](std::string_view column) const;

  std::string_view row() const { return row_; }
  const std::vector<std::string_view>& cells() const { return cells_; }
  std::size_t line() const { return line_; }  ///< number of the row's first line, from 1

 private:
  std::size_t read_quoted_row();

  std::string_view rest_, row_;
  CsvDialect dialect_;
  std::vector<std::string> names_;
  std::vector<std::string_view> cells_;
  std::deque<std::string> unquoted_;  ///< cells that were in quotes
  std::size_t line_ = 1, lines_ = 0;  ///< `lines_` were read
};

}  // namespace tactile
