#pragma once

#include <vector>

#include "tactile/alignment/anchor_search.hpp"

namespace tactile::alignment {

/// The host as a witness: host times of the log's rows and of the camera's data. Host time is divided into equal stretches; in
/// each, only the element of either device with the shortest delay counts, because late ones give no information. Without such
/// times there are no anchors.
std::vector<ClockAnchor> host_anchors(const AnchorInputs& inputs);

}  // namespace tactile::alignment
