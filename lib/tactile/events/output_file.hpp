#pragma once

#include <filesystem>

namespace tactile::events {

/// Protects the input, whatever path or hard link leads to it.
/// @throws Error  if `target` is `input` or a folder, or exists and must not be replaced
void check_target(const std::filesystem::path& target, const std::filesystem::path& input, bool replace);

}  // namespace tactile::events
