#include "tactile/capture/dv_bridge.hpp"

#include <filesystem>
#include <system_error>

namespace tactile::capture {

std::string dv_bridge() {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);  // in libexec/tactile if it is installed
  const fs::path installed = (program.parent_path() / "../../share/tactile/scripts/dv-bridge").lexically_normal();
  return fs::exists(installed, none) ? installed.string() : "scripts/dv-bridge";
}

}  // namespace tactile::capture
