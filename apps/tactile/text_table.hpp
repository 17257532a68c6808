#pragma once

#include <string>
#include <vector>

namespace tactile {

/// Rows of cells under a header, columns aligned: the first to the left, the others to the right.
std::string text_table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);

}  // namespace tactile
