#pragma once

#include "tactile/core/time.hpp"

namespace tactile::alignment {

/// A stretch of camera time, half-open.
struct CameraSpan {
  CameraTime begin{}, end{};
};

}  // namespace tactile::alignment
