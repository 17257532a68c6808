#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "tactile/core/ticks.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/run_ticks.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::heatmaps {

/// Receives one tick: its time, its heatmap ([height, width], valid until it returns) and the number of events in [t_c - t_h,
/// t_c).
using TickCallback = std::function<void(CameraTime tick, std::span<const std::uint8_t> heatmap, std::uint64_t events_in_window)>;

using events::ChangeEvents;

/// Renders every full tick of a run, in order: those with t_c - t_h >= its first event's time and t_c <= its last event's.
///
/// @param events  the whole run's, ascending in time
/// @return        the rendered ticks, as `full_ticks`
/// @throws Error  if the events go back in time or lie outside the sensor, there are more than `most_ticks`, or as `check`
TickRange for_every_tick(std::span<const events::Event> events, events::SensorSize sensor, const HeatmapOptions& options,
                         const TickCallback& use);

/// The same for an event stream of a recording, packet by packet: memory follows the packet and the history.
/// @throws Error  also if the stream declares no size. More than `most_ticks` in the list of packets throw before any tick is
/// used
/// @param change  as `events::follow_ticks` takes it
TickRange for_every_tick(events::RecordingReader& recording, std::int32_t stream_id, const HeatmapOptions& options,
                         const TickCallback& use, const ChangeEvents& change = {});

/// The full ticks of an event stream according to the recording's list of packets, without reading a packet.
TickRange listed_ticks(const events::RecordingReader& recording, std::int32_t stream_id, const HeatmapOptions& options);

}  // namespace tactile::heatmaps
