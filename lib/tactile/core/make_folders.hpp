#pragma once

#include <filesystem>

namespace tactile {

/// Makes a folder and those above it that are missing. Their names outlive a power cut, and with them what is put there and
/// synced.
/// @throws Error if one cannot be made
void make_folders(const std::filesystem::path& folder);

/// For an output that is not written after all: removes a folder, and those above it, as far as `make_folders` made them in this
/// process and they are empty.
void remove_empty_made_folders(std::filesystem::path folder);

}  // namespace tactile
