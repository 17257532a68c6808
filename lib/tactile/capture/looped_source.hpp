#pragma once

#include <functional>
#include <memory>

#include "tactile/capture/camera_source.hpp"

namespace tactile {

/// A source that is opened anew whenever it has ended, for ever, with times that go on ascending: each round begins `gap` after
/// the latest element of the one before. Ends only if a round brought nothing at all.
/// @param open  gives the same source each time
/// @param gap   between two rounds, in camera time, > 0
std::unique_ptr<CameraSource> looped_source(std::function<std::unique_ptr<CameraSource>()> open, microseconds gap);

}  // namespace tactile
