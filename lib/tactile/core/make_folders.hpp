#pragma once

#include <filesystem>

namespace tactile {

/// Makes a folder and those above it that are missing. Their names outlive a power cut, and with them what is put there and
/// synced.
/// @throws Error if one cannot be made
void make_folders(const std::filesystem::path& folder);

}  // namespace tactile
