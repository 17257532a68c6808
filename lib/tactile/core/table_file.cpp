#include "tactile/core/table_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"

namespace tactile {

TableFile::TableFile(const std::filesystem::path& file, const TableFormat& format)
    : file_(file.string()), in_(file, std::ios::binary), ends_in_any_bytes_(format.ends_in_any_bytes) {
  if (!in_ || std::filesystem::is_directory(file))
    throw Error(fmt::format("{}: cannot be read; expected {}", file_, format.name));
  while (read_line()) {
    constexpr std::string_view mark = "\xEF\xBB\xBF";  // some editors put it before UTF-8
    if (number_ == 1 && line_.starts_with(mark)) line_.erase(0, mark.size());
    separator_ = separator_of(trimmed(line_));
    split_cells(line_, separator_, cells_);
    if (is_blank()) continue;
    take_names(format);
    return;
  }
  throw Error(fmt::format("{}: is empty; expected a header row with {}", file_, format.header));
}

void TableFile::take_names(const TableFormat& format) {
  const auto is_number = [](std::string_view cell) { return number_in(cell).has_value(); };
  if (format.columns.empty()) {
    if (std::all_of(cells_.begin(), cells_.end(), is_number)) {
      throw Error(fmt::format(
          "{}: begins with a row of {} numbers, and has no header; expected a header row with {}{}", file_, cells_.size(),
          format.header,
          format.columns_option.empty() ? "" : fmt::format(", or {} with a name or - for each column", format.columns_option)));
    }
    names_.assign(cells_.begin(), cells_.end());
    return;
  }
  names_ = format.columns;
  if (names_.size() != cells_.size()) {
    throw Error(fmt::format("{}: row {} has {} values, but {} names {}; expected a name or - for each", file_, number_,
                            cells_.size(), format.columns_option, names_.size()));
  }
  is_read_ = std::any_of(cells_.begin(), cells_.end(), is_number);
}

std::optional<std::size_t> TableFile::find(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) return std::nullopt;
  if (std::find(found + 1, names_.end(), name) != names_.end())
    throw Error(fmt::format("{}: two columns have the name '{}'; expected one", file_, name));
  return static_cast<std::size_t>(found - names_.begin());
}

bool TableFile::next() {
  if (std::exchange(is_read_, false)) return true;
  if (!read_line()) return false;
  split_cells(line_, separator_, cells_);
  return true;
}

int TableFile::next_byte() {
  if (chunk_at_ == chunk_size_) {
    in_.read(chunk_.data(), static_cast<std::streamsize>(chunk_.size()));
    chunk_at_ = 0;
    chunk_size_ = static_cast<std::size_t>(in_.gcount());
    if (in_.bad()) throw Error(file_ + ": reading failed; expected a readable file");
    if (chunk_size_ == 0) return -1;
  }
  return static_cast<unsigned char>(chunk_[chunk_at_++]);
}

bool TableFile::read_line() {
  line_.clear();
  ++number_;
  for (int byte = next_byte();; byte = next_byte()) {
    if (byte < 0) {
      is_ended_ = false;
      return !line_.empty();
    }
    if (byte == '\n' || byte == '\r') {
      while (byte == '\r') byte = next_byte();
      if (byte >= 0 && byte != '\n') --chunk_at_;  // it was read just now, so it is still there
      is_ended_ = true;
      if (line_.size() > longest_row) refuse_length();
      return true;
    }
    if (line_.size() <= longest_row)
      line_ += static_cast<char>(byte);
    else if (!ends_in_any_bytes_)
      refuse_length();
  }
}

double TableFile::number_at(std::size_t column) const {
  const std::optional<double> value = number_in(cells_[column]);
  if (!value || !std::isfinite(*value)) refuse(column, "a finite number");
  return *value;
}

std::int64_t TableFile::whole_number_at(std::size_t column) const {
  if (const std::optional<std::int64_t> value = whole_number_in(cells_[column])) return *value;
  const std::optional<double> value = number_in(cells_[column]);
  constexpr double limit = 9007199254740992.0;  // 2^53: beyond it a double skips whole numbers
  if (!value || !(std::abs(*value) <= limit) || *value != std::floor(*value)) refuse(column, "a whole number");
  return static_cast<std::int64_t>(*value);
}

std::uint64_t TableFile::bits_at(std::size_t column) const {
  const std::string_view cell = cells_[column];
  if (cell == "True" || cell == "False") return cell == "True" ? 1 : 0;
  std::uint64_t bits = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), bits);
  if (error == std::errc{} && end == cell.data() + cell.size()) return bits;
  const std::optional<double> value = number_in(cell);
  constexpr double limit = 9007199254740992.0;
  if (!value || !(*value >= 0.0 && *value <= limit) || *value != std::floor(*value))
    refuse(column, "a whole number of at least 0");
  return static_cast<std::uint64_t>(*value);
}

void TableFile::refuse_length() const {
  throw Error(fmt::format("{}: row {} has no end within {} bytes; expected text in rows", file_, number_, longest_row));
}

void TableFile::refuse_row() const {
  throw Error(
      fmt::format("{}: row {} has {} values; expected {}, as in its header", file_, number_, cells_.size(), names_.size()));
}

void TableFile::refuse(std::size_t column, std::string_view expected) const {
  throw Error(fmt::format("{}: row {}, column '{}' holds {}; expected {}", file_, number_, names_[column],
                          shown_text(cells_[column]), expected));
}

}  // namespace tactile
