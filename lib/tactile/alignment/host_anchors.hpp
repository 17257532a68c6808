#pragma once

#include <vector>

#include "tactile/alignment/anchor_search.hpp"

namespace tactile::alignment {

/// The host as a witness: host times of the log's rows and of the camera's data. Host time is divided into equal stretches; in
/// each, the element of either device that arrived soonest counts, since late ones say nothing. None without such times.
std::vector<ClockAnchor> host_anchors(const AnchorInputs& inputs);

}  // namespace tactile::alignment
