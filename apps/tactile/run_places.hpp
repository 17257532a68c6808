#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/runs_below.hpp"

namespace tactile::cli {

enum class LeftOutFolders : std::uint8_t { warn, say_nothing };

/// The runs in the folder of an object. @throws Error  if the object is misnamed
std::vector<RunFolder> runs_of_object(const std::filesystem::path& place);

/// Runs, folders of an object's runs, and data folders as all of their runs; each run once.
/// @param left_out  of folders that hold no run: their warnings are logged, or not
/// @throws Error  if a place is a file, or holds no run
RunsBelow runs_in(const std::vector<std::string>& places, LeftOutFolders left_out = LeftOutFolders::warn);

}  // namespace tactile::cli
