#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "tactile/core/text_lines.hpp"

namespace tactile::cli {

/// Rows of cells under a header. The first column is aligned left, the others right. A last column without header contains
/// remarks, and is aligned left, too.
std::string text_table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);

/// Names and values, one pair per line, the values aligned.
std::string text_list(const std::vector<std::pair<std::string, std::string>>& entries);

}  // namespace tactile::cli
