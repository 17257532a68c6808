#pragma once

#include <string_view>

namespace tactile {

// The files of configs/ that are the simulation's defaults, as they were when this was built.
std::string_view default_simulation_config();
std::string_view default_objects_config();

}  // namespace tactile
