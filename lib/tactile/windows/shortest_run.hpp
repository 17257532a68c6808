#pragma once

#include "tactile/windows/sample.hpp"

namespace tactile::windows {

/// history + guard + 2 tick: a tick of each class, `none` with its distance from the two others. A shorter recording lacks one.
inline microseconds shortest_run(const SamplingOptions& options) { return options.history + options.guard + 2 * options.tick; }

}  // namespace tactile::windows
