#pragma once

#include "tactile/video/opencv_part.hpp"

namespace tactile::video {

/// The part, which is loaded by the first call. Any thread. @throws Error  if it cannot be loaded (core/loaded_part.hpp)
const OpenCvPart& opencv_part();

}  // namespace tactile::video
