#pragma once

#include "tactile/model/inference/stream_network.hpp"

namespace tactile::model {

/// `StreamNetwork::advance`, by the widest vectors of the processor.
void advance_stream(const StreamPlan& plan, const StreamCounts& counts, StreamState& state);

}  // namespace tactile::model
