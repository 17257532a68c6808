#pragma once

#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/labels/arm_moves.hpp"

namespace tactile::labels {

/// The bursts of a run, by time: those of the rate, split where well-placed lifts begin and joined within them, and those that
/// only a few places show (`slow_bursts`). A slow burst that continues in another is its begin.
/// @throws Error  as reading events does
std::vector<alignment::Burst> bursts_of_run(events::RecordingReader& recording, const alignment::RunSignals& signals,
                                            const std::vector<ArmMove>& lifts, const alignment::ActivityOptions& options);

}  // namespace tactile::labels
