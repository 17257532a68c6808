#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tactile {

enum class Links : std::uint8_t { follow, skip };  ///< symbolic links to folders

/// The folders in `folder`, by name. What cannot be read is left out.
std::vector<std::filesystem::path> folders_in(const std::filesystem::path& folder, Links links = Links::follow);

}  // namespace tactile
