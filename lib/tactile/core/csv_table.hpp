#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tactile {

/// A number as a cell, with this many significant digits; an empty one if it is not finite. Nine digits name a float32.
std::string csv_number(double number, int digits = 9);
std::string csv_number(const std::optional<double>& number, int digits = 9);

/// Cells with commas between them: each argument is a text, a whole number, or several texts in a row, such as a figure and its
/// interval. Texts are cells of `csv_cell`.
class CsvCells {
 public:
  template <class... Cells>
  explicit CsvCells(const Cells&... cells) {
    (add(cells), ...);
  }

  std::size_t count() const { return count_; }
  const std::string& text() const { return text_; }

 private:
  void add(std::string_view text);
  void add(std::span<const std::string> texts);
  template <std::integral Whole>
  requires(!std::same_as<Whole, bool> && !std::same_as<Whole, char>) void add(Whole number) {
    add(std::string_view(std::to_string(number)));
  }
  template <std::integral Whole>
  void add(const std::optional<Whole>& number) {
    number ? add(*number) : add(std::string_view());
  }

  std::size_t count_ = 0;
  std::string text_;
};

/// A row without its end, for a file that is written row by row. @param cells  as of `CsvCells`
template <class... Cells>
std::string csv_row(const Cells&... cells) {
  return CsvCells(cells...).text();
}

/// A table as CSV text: the names of its columns, then rows of as many cells.
class CsvTable {
 public:
  /// @param columns  "x,y,kind"
  explicit CsvTable(std::string_view columns);

  /// Adds a row. @param cells  as of `CsvCells`
  template <class... Cells>
  void add_row(const Cells&... cells) {
    add(CsvCells(cells...));
  }

  const std::string& text() const { return text_; }

 private:
  void add(const CsvCells& row);

  std::size_t columns_;
  std::string text_;
};

}  // namespace tactile
