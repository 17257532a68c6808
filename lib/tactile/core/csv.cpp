#include "tactile/core/csv.hpp"

#include <algorithm>

#include "tactile/core/text.hpp"

namespace tactile {

std::vector<std::string_view> split_cells(std::string_view row, char separator) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(row.find(separator, begin), row.size());
    cells.push_back(row.substr(begin, end - begin));
    if (end == row.size()) return cells;
    begin = end + 1;
  }
}

void split_cells(std::string_view row, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  if (separator == ' ' || trimmed(row).empty()) row = trimmed(row);
  if (row.empty()) return;
  for (std::size_t begin = 0;;) {
    const std::size_t first = std::min(row.find_first_not_of(separator == '\t' ? " " : " \t", begin), row.size());
    if (separator == ' ') begin = first;  // aligned columns have several blanks between them
    std::size_t end = row.find(separator, begin);
    std::string_view cell = trimmed(row.substr(begin, end == std::string_view::npos ? end : end - begin));
    if (first < std::min(end, row.size()) && row[first] == '"') {
      std::size_t close = row.find('"', first + 1);
      while (close != std::string_view::npos && row.substr(close + 1).starts_with('"')) close = row.find('"', close + 2);
      if (close != std::string_view::npos) {
        cell = row.substr(first + 1, close - first - 1);
        end = row.find(separator, close + 1);
      }
    }
    cells.push_back(cell);
    if (end == std::string_view::npos) return;
    begin = end + 1;
  }
}

char separator_of(std::string_view header) {
  const auto count = [&](char mark) {
    std::size_t found = 0;
    bool is_quoted = false;
    for (const char c : header) {
      if (c == '"') is_quoted = !is_quoted;
      if (c == mark && !is_quoted) ++found;
    }
    return found;
  };
  char best = ',';
  for (const char mark : {';', '\t'}) {
    if (count(mark) > count(best)) best = mark;
  }
  return count(best) == 0 && count(' ') > 0 ? ' ' : best;
}

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",;\t\"\r\n") == std::string_view::npos) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

CsvRows::CsvRows(std::string_view text, CsvDialect dialect) : rest_(text), dialect_(dialect) {
  next();
  names_.assign(cells_.begin(), cells_.end());
}

bool CsvRows::next() {
  if (rest_.empty()) return false;
  line_ = lines_ + 1;
  std::size_t end = std::min(rest_.find('\n'), rest_.size());
  if (dialect_.has_quotes) end = read_quoted_row();
  row_ = rest_.substr(0, end);
  if (row_.ends_with('\r')) row_.remove_suffix(1);
  if (!dialect_.has_quotes) cells_ = split_cells(row_, dialect_.separator);
  lines_ += 1 + static_cast<std::size_t>(std::count(row_.begin(), row_.end(), '\n'));
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  return true;
}

bool CsvRows::next_filled() {
  while (next()) {
    if (!row_.empty()) return true;
  }
  return false;
}

std::size_t CsvRows::read_quoted_row() {
  cells_.clear();
  unquoted_.clear();
  for (std::size_t at = 0;; ++at) {
    const std::size_t begin = at;
    const bool is_quoted = at < rest_.size() && rest_[at] == '"';
    bool is_open = is_quoted;
    std::string text;
    for (at += is_quoted ? 1 : 0; at < rest_.size(); ++at) {
      const char c = rest_[at];
      if (!is_open && (c == dialect_.separator || c == '\n')) break;
      const bool is_doubled = is_open && c == '"' && rest_.substr(at + 1).starts_with('"');
      if (is_open && c == '"' && !is_doubled)
        is_open = false;
      else if (is_quoted)
        text += c;
      at += is_doubled ? 1 : 0;
    }
    const bool is_last = at == rest_.size() || rest_[at] == '\n';
    const bool has_return = is_last && at > begin && rest_[at - 1] == '\r';
    if (is_quoted) {
      if (has_return && !text.empty()) text.pop_back();
      cells_.push_back(unquoted_.emplace_back(std::move(text)));
    } else {
      cells_.push_back(rest_.substr(begin, at - begin - (has_return ? 1 : 0)));
    }
    if (is_last) return at;
  }
}

std::optional<std::size_t> CsvRows::column(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  return found == names_.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - names_.begin()));
}

std::optional<std::string_view> CsvRows::operator[](std::string_view name) const {
  const std::optional<std::size_t> index = column(name);
  return index && *index < cells_.size() ? std::optional(cells_[*index]) : std::nullopt;
}

}  // namespace tactile
