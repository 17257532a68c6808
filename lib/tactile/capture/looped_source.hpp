#pragma once

#include <functional>
#include <memory>

#include "tactile/capture/camera_source.hpp"

namespace tactile::capture {

/// A source that is opened again whenever it ends, with ascending times: each round begins `gap` after the latest element of the
/// previous one. Ends only after a round without elements.
/// @param open  opens the same source each time
/// @param gap   between two rounds, in camera time, > 0
std::unique_ptr<CameraSource> looped_source(std::function<std::unique_ptr<CameraSource>()> open, microseconds gap);

}  // namespace tactile::capture
