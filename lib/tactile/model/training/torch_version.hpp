#pragma once

#include <string>

namespace tactile::model {

/// The version of libtorch of this build, "1.13.1".
std::string torch_version();

/// Loads libtorch now, instead of at its first use. @throws Error  if it cannot be loaded
void load_libtorch();

}  // namespace tactile::model
