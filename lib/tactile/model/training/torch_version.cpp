#include "tactile/model/training/torch_version.hpp"

#include <torch/version.h>

namespace tactile::model {

std::string torch_version() { return TORCH_VERSION; }

}  // namespace tactile::model
