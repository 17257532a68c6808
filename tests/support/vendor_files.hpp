#pragma once

#include <filesystem>

#include "support/paths.hpp"

namespace tactile::test {

/// Recordings that the vendor's library wrote.
inline const std::filesystem::path vendor_files = std::filesystem::path(data_folder) / "aedat4";

}  // namespace tactile::test
