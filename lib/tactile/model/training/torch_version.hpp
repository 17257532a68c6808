#pragma once

#include <string>

namespace tactile::model {

/// The version of libtorch of this build, "1.13.1".
std::string torch_version();

}  // namespace tactile::model
