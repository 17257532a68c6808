#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tactile::cli {

/// Whether a file is a recording by its name: `.aedat4`, `.raw` or a bag.
bool has_recording_name(const std::filesystem::path& file);

/// The recordings in a folder of loose ones, as DV and other programs save them, by name: `.aedat4`, `.raw` and bags.
std::vector<std::string> loose_recordings_in(const std::filesystem::path& folder);

}  // namespace tactile::cli
