#pragma once

#include <filesystem>

namespace tactile {

/// Renames `from` to `to` unless `to` exists, in one step where the file system can. @return  0, EEXIST, or another errno
[[nodiscard]] int rename_if_free(const std::filesystem::path& from, const std::filesystem::path& to);

/// Renames the folder `from` to `to`, and an existing folder `to` to `from`. @return  0 or errno
[[nodiscard]] int exchange_folders(const std::filesystem::path& from, const std::filesystem::path& to);

/// Renames the file `from` to `to`, which it replaces. @return  0 or errno
[[nodiscard]] int replace_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace tactile
