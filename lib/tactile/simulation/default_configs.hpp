#pragma once

#include <string_view>

namespace tactile::simulation {

// The files of configs/ with the simulation's defaults, as of the build.
std::string_view default_simulation_config();
std::string_view default_cameras_config();
std::string_view default_objects_config();

}  // namespace tactile::simulation
