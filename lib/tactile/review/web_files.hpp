#pragma once

#include <span>

#include "tactile/review/page_server.hpp"

namespace tactile::review {

/// The files of apps/tactile/web and of dygraphs, which the build puts into the program.
std::span<const WebFile> web_files();

}  // namespace tactile::review
