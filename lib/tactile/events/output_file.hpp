#pragma once

#include <filesystem>

namespace tactile {

/// The input is never written over, through whatever path or hard link the target reaches it.
/// @throws Error  if `target` is `input` or a folder, or exists already and is not to be replaced
void check_target(const std::filesystem::path& target, const std::filesystem::path& input, bool replace);

}  // namespace tactile
