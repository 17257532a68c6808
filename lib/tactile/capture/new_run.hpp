#pragma once

#include <filesystem>
#include <string>

#include "tactile/core/run_folder.hpp"

namespace tactile::capture {

/// Creates `DATA/<object>/<run>/` for a new run: `run` or, if that is empty, the number after the highest existing one (after 99
/// the lowest free one). Two calls at the same time create two folders.
/// @throws Error  if a name is invalid, the run exists already, 01 to 99 all exist, or the folder cannot be created
RunFolder make_run_folder(const std::filesystem::path& data, const std::string& object, const std::string& run = {});

/// Renames the run to `NN.discarded-K`, which no command reads. @return  that folder. @throws Error  if it cannot be renamed
std::filesystem::path discard_run(const RunFolder& run);

}  // namespace tactile::capture
