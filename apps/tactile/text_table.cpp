#include "text_table.hpp"

#include <algorithm>

namespace tactile::cli {

std::string text_table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const std::string& cell : header) widths.push_back(characters_in(cell));
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size() && i < widths.size(); ++i) widths[i] = std::max(widths[i], characters_in(row[i]));
  }
  std::string text;
  const auto add_row = [&](const std::vector<std::string>& row) {
    std::string line;
    for (std::size_t i = 0; i < widths.size(); ++i) {
      const std::string cell = i < row.size() ? row[i] : std::string();
      const std::string padding(widths[i] - characters_in(cell), ' ');
      const bool is_left = i == 0 || (i + 1 == widths.size() && header[i].empty());
      line += (i == 0 ? "" : "  ") + (is_left ? cell + padding : padding + cell);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  };
  add_row(header);
  for (const auto& row : rows) add_row(row);
  return text;
}

std::string text_list(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::size_t width = 0;
  for (const auto& [name, value] : entries) width = std::max(width, characters_in(name));
  std::string text;
  for (const auto& [name, value] : entries) text += name + std::string(width - characters_in(name) + 2, ' ') + value + '\n';
  return text;
}

}  // namespace tactile::cli
