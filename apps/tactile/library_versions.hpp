#pragma once

#include <string>
#include <vector>

namespace tactile::cli {

struct LibraryVersion {
  std::string name;  ///< "OpenCV"
  std::string version;
};

/// The libraries of other projects that `tactile-all` is built with, and that affect results or files.
std::vector<LibraryVersion> library_versions();

/// One line for each of them, and one without a line end with the vector instructions in use and the others that this processor
/// has: what `tactile --version` prints after its first line.
std::string libraries_text();

}  // namespace tactile::cli
