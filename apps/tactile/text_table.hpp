#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace tactile {

/// Rows of cells under a header, columns aligned: the first to the left, the others to the right. Where the last has no header it
/// holds words, such as remarks: to the left too.
std::string text_table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);

/// `text` in lines of at most `width` characters where its words allow it; all but the first are indented.
std::string wrapped(const std::string& text, std::size_t indent = 0, std::size_t width = 80);

/// Names and what they are, one a line, the values aligned.
std::string text_list(const std::vector<std::pair<std::string, std::string>>& entries);

}  // namespace tactile
