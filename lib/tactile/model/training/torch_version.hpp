#pragma once

#include <string>

namespace tactile {

/// The version of libtorch that this was built with, "1.13.1".
std::string torch_version();

}  // namespace tactile
