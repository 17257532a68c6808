#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "tactile/core/text_lines.hpp"

namespace tactile {

/// Rows of cells under a header, columns aligned: the first to the left, the others to the right. Where the last has no header it
/// holds words, such as remarks: to the left too.
std::string text_table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);

/// Names and what they are, one a line, the values aligned.
std::string text_list(const std::vector<std::pair<std::string, std::string>>& entries);

}  // namespace tactile
