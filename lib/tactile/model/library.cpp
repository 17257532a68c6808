#include "tactile/model/library.hpp"

#include <torch/version.h>

namespace tactile {

std::string torch_version() { return TORCH_VERSION; }

}  // namespace tactile
