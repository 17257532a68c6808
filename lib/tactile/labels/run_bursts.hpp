#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/labels/arm_moves.hpp"

namespace tactile::labels {

/// The bursts of a run, by time: those of the rate, split where well-placed lifts begin and joined within them, and those that
/// only a few places show (`slow_bursts`). A slow burst that continues in another is its start.
/// @throws Error  as reading events does
std::vector<alignment::Burst> bursts_of_run(events::RecordingReader& recording, const alignment::RunSignals& signals,
                                            const std::vector<ArmMove>& lifts, const alignment::ActivityOptions& options);

/// The part of it that needs no signals of a run: bursts within lifts are joined, and slow ones added.
/// @param bursts  those of the rate, by time
/// @param pauses  in which nothing was recorded: they show nothing of the noise
std::vector<alignment::Burst> joined_and_slow_bursts(events::RecordingReader& recording, std::int32_t stream_id,
                                                     const alignment::EventRate& rate, const alignment::QuietRate& quiet,
                                                     std::vector<alignment::Burst> bursts, const std::vector<ArmMove>& lifts,
                                                     std::span<const alignment::Burst> pauses = {});

}  // namespace tactile::labels
