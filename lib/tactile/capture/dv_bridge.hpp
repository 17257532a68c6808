#pragma once

#include <string>

namespace tactile::capture {

/// The script that serves a camera which libcaer does not open: its path where it is installed with this program, or else
/// "scripts/dv-bridge", its place among the sources.
std::string dv_bridge();

}  // namespace tactile::capture
