#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactile {

/// What a table file is expected to be; for messages.
struct TableFormat {
  std::string_view name;                  ///< such as "a robot log"
  std::string_view header;                ///< what its first row has, such as "RTDE's names"
  std::vector<std::string> columns = {};  ///< names for the columns; a first row without numbers is then skipped. Empty: the
                                          ///< first row is the header
  std::string_view columns_option = {};   ///< the option that gives `columns`
  bool ends_in_any_bytes = false;         ///< a last row without end may be longer than `longest_row`
};

/// A text file of rows; the first row names the columns, or they are given. Cells are separated
/// by commas, semicolons, tabs or blanks, as in the header, and quoted where they hold that separator. Rows end with LF, CR LF,
/// CR CR LF (which Windows makes of CR LF) or CR. Memory follows the longest row.
class TableFile {
 public:
  static constexpr std::size_t longest_row = std::size_t{1} << 20;  ///< [bytes]

  /// Opens the file and reads its header.
  /// @throws Error  naming the file, if it cannot be read, is empty, is not text in rows or has another number of columns
  TableFile(const std::filesystem::path& file, const TableFormat& format);

  const std::string& file() const { return file_; }
  const std::vector<std::string>& names() const { return names_; }  ///< of the columns, in their order

  /// The column of this name. @throws Error  if there are two
  std::optional<std::size_t> find(std::string_view name) const;

  /// Reads the next row. @return whether there is one  @throws Error  if reading fails, or if a row has no end
  bool next();

  /// As it is in the file, without its end; before the first `next` the header, or without one the first row.
  std::string_view row() const { return line_; }
  char separator() const { return separator_; }
  bool is_blank() const { return cells_.empty(); }  ///< the row is empty
  bool is_ended() const { return is_ended_; }       ///< else the file ends within the row
  bool is_whole() const { return cells_.size() == names_.size(); }
  std::size_t number() const { return number_; }  ///< of the row, 1 is the first of the file
  /// Without blanks and quotes around them, valid until the next row.
  const std::vector<std::string_view>& cells() const { return cells_; }

  // Values of one cell. Each throws an Error with file, row and column if the cell holds another kind of value.
  double number_at(std::size_t column) const;              ///< finite
  std::int64_t whole_number_at(std::size_t column) const;  ///< "3.0" is one too
  std::uint64_t bits_at(std::size_t column) const;         ///< a whole number of at least 0; True and False are 1 and 0

  [[noreturn]] void refuse_row() const;  ///< because it is not whole
  [[noreturn]] void refuse(std::size_t column, std::string_view expected) const;

 private:
  bool read_line();
  int next_byte();
  void take_names(const TableFormat& format);
  [[noreturn]] void refuse_length() const;

  std::string file_;
  std::ifstream in_;
  std::array<char, 1 << 16> chunk_{};
  std::size_t chunk_at_ = 0, chunk_size_ = 0;
  std::string line_;
  bool ends_in_any_bytes_;
  bool is_ended_ = true;
  bool is_read_ = false;  ///< the next row was read already, because there is no header
  std::size_t number_ = 0;
  char separator_ = ',';
  std::vector<std::string> names_;
  std::vector<std::string_view> cells_;
};

}  // namespace tactile
