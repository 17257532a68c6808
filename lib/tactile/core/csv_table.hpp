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

/// A table as CSV text: the names of its columns, then rows of as many cells. Texts are cells of `csv_cell`.
class CsvTable {
 public:
  /// @param columns  "x,y,kind"
  explicit CsvTable(std::string_view columns);

  /// Adds a row. Each argument is a text, a whole number, or several texts in a row, such as a figure and its interval.
  template <class... Cells>
  void add_row(const Cells&... cells) {
    (add(cells), ...);
    end_row();
  }

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
  void end_row();

  std::size_t columns_;
  std::size_t cells_ = 0;  ///< of the row that is being added
  std::string text_;
};

}  // namespace tactile
