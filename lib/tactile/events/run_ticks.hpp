#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "tactile/core/ticks.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::events {

/// Changes the events of a run on their way to what reads them, chunk by chunk. A function with a state, of one run.
/// @param recorded  ascending in time; empty in the last call, which gives what was held back
/// @return  ascending in time, also from call to call; valid until the next call
using ChangeEvents = std::function<std::span<const Event>(std::span<const Event> recorded, bool is_last)>;

/// What follows a run from tick to tick.
struct TickFollower {
  std::function<void(std::span<const Event>)> add;  ///< the next events, ascending in time
  std::function<void(CameraTime)> tick;             ///< a full tick: all events before it are given, some later ones too
};

/// Follows every full tick of a run, in order: those with t - history >= its first event's time and t <= its last event's.
///
/// @param events  the whole run's, ascending in time
/// @return        the ticks, as `full_ticks`
/// @throws Error  if there are more than `most_ticks`, or as `full_ticks`
TickRange follow_ticks(std::span<const Event> events, microseconds history, microseconds tick, const TickFollower& follower);

/// The same for an event stream of a recording, packet by packet: memory follows the packet.
/// @throws Error  also if the recording cannot be read. More than `most_ticks` in the list of packets throw before any tick
/// @param change  changes the events on their way; empty: they stay. The ticks are those of the recorded events, so that a run
///                without some of its events has the same ticks.
TickRange follow_ticks(RecordingReader& recording, std::int32_t stream_id, microseconds history, microseconds tick,
                       const TickFollower& follower, const ChangeEvents& change = {});

/// The full ticks of an event stream according to the recording's list of packets, without reading a packet.
TickRange listed_ticks(const RecordingReader& recording, std::int32_t stream_id, microseconds history, microseconds tick);

}  // namespace tactile::events
