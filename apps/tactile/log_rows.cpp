#include "log_rows.hpp"

#include <algorithm>
#include <array>
#include <fstream>

#include "tactile/core/numbers.hpp"

namespace tactile::cli {
namespace {

/// The cell of this index; empty if the row is shorter.
std::string_view cell(std::string_view row, char separator, std::size_t index) {
  for (; index > 0; --index) {
    const std::size_t end = row.find(separator);
    if (end == std::string_view::npos) return {};
    row.remove_prefix(end + 1);
  }
  return row.substr(0, row.find(separator));
}

std::string_view without_return(std::string_view row) {
  if (row.ends_with('\r')) row.remove_suffix(1);
  return row;
}

}  // namespace

std::optional<LogRows> log_rows(const std::filesystem::path& file, std::string_view column, double unit_s,
                                double longest_step_s) {
  std::ifstream in(file, std::ios::binary);
  std::array<char, 65536> line{};
  if (!in.getline(line.data(), line.size())) return std::nullopt;
  const std::string_view header = without_return(line.data());
  const std::size_t place = header.find_first_of(",;\t ");
  const char separator = place == std::string_view::npos ? ',' : header[place];
  const auto columns = static_cast<std::size_t>(std::count(header.begin(), header.end(), separator)) + 1;
  std::size_t index = 0;
  while (index < columns && cell(header, separator, index) != column) ++index;
  if (index == columns) return std::nullopt;

  LogRows found;
  std::uint64_t steps = 0, empty = 0;
  double stepped_s = 0;
  std::optional<double> before;
  while (in.getline(line.data(), line.size()) && !in.eof()) {  // at the end of the file a row lacks its newline
    const std::string_view row = without_return(line.data());
    if (row.empty()) {
      ++empty;
      before.reset();
      continue;
    }
    if (found.rows > 0) found.gaps += empty;
    empty = 0;
    ++found.rows;
    const std::optional<double> t = number_in(cell(row, separator, index));
    if (t && before) {
      const double step_s = unit_s * (*t - *before);
      if (step_s > 0 && step_s <= longest_step_s) {
        ++steps;
        stepped_s += step_s;
      }
    }
    before = t;
  }
  if (!in.eof()) return std::nullopt;
  if (steps > 0) found.rate_hz = static_cast<double>(steps) / stepped_s;
  return found;
}

}  // namespace tactile::cli
