#pragma once

#include <filesystem>
#include <string>

#include "tactile/core/run_folder.hpp"

namespace tactile {

/// Makes `DATA/<object>/<run>/` for a new run: `run`, or where that is empty the number after the highest that is there (past 99
/// the lowest free one). Whoever makes the folder has it, so two that ask at once get two.
/// @throws Error  if the names are none, the run exists already, 01 to 99 are all taken, or the folder cannot be made
RunFolder make_run_folder(const std::filesystem::path& data, const std::string& object, const std::string& run = {});

/// Renames the run to `NN.discarded-K`, which no command reads, and returns that folder. @throws Error if it cannot be renamed
std::filesystem::path discard_run(const RunFolder& run);

}  // namespace tactile
