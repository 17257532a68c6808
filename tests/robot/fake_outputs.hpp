#pragma once

#include <string>
#include <vector>

#include "tactile/robot/rtde_protocol.hpp"

namespace tactile::test {

/// The controller's reply to a request of outputs, and the recipe that it then sends.
robot::RtdeSetupReply types_for(const robot::RtdeOutputsRequest& request, const std::vector<std::string>& not_found,
                                robot::RtdeRecipe& recipe);

/// The numbers of a data package at a moment of the script [s].
std::vector<robot::RtdeNumber> numbers_for(const robot::RtdeRecipe& recipe, double timestamp, double script_s);

}  // namespace tactile::test
