#include "tactile/report/csv_reader.hpp"

#include <algorithm>

#include "tactile/core/whole_file.hpp"

namespace tactile {

CsvReader::CsvReader(const std::filesystem::path& file, std::size_t largest)
    : text_(read_text(file, largest)), columns_(take_line()) {}

bool CsvReader::has(std::string_view column) const {
  return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
}

bool CsvReader::next() {
  while (at_ < text_.size()) {
    fields_ = take_line();
    if (fields_.size() > 1 || !fields_[0].empty()) return true;
  }
  return false;
}

std::optional<std::string_view> CsvReader::operator[](std::string_view column) const {
  const auto index = static_cast<std::size_t>(std::find(columns_.begin(), columns_.end(), column) - columns_.begin());
  return index < columns_.size() && index < fields_.size() ? std::optional(fields_[index]) : std::nullopt;
}

std::vector<std::string_view> CsvReader::take_line() {
  const std::size_t end = std::min(text_.find('\n', at_), text_.size());
  std::string_view line = std::string_view(text_).substr(at_, end - at_);
  at_ = end + 1;
  ++line_;
  if (line.ends_with('\r')) line.remove_suffix(1);
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = std::min(line.find(',', begin), line.size());
    fields.push_back(line.substr(begin, comma - begin));
    if (comma == line.size()) return fields;
    begin = comma + 1;
  }
}

}  // namespace tactile
