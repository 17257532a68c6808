#pragma once

#include <string_view>

namespace tactile {

std::string_view version();   ///< as in CMakeLists.txt, "1.0.0"
std::string_view revision();  ///< git's short commit id, "-dirty" appended where files differ from it

}  // namespace tactile
