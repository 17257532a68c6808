#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/alignment/activity.hpp"
#include "tactile/alignment/event_rate.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/splitting/touches.hpp"

namespace tactile::splitting {

/// Bursts within one lift are joined, and those that only a few places show are added (`slow_bursts`). A slow burst that
/// continues in another is its start.
/// @param bursts  those of the rate, by time
/// @param pauses  in which nothing was recorded: they show nothing of the noise
/// @throws Error  as reading events does
std::vector<alignment::Burst> joined_and_slow_bursts(events::RecordingReader& recording, std::int32_t stream_id,
                                                     const alignment::EventRate& rate, const alignment::QuietRate& quiet,
                                                     std::vector<alignment::Burst> bursts, const std::vector<ArmMove>& lifts,
                                                     std::span<const alignment::Burst> pauses = {});

}  // namespace tactile::splitting
