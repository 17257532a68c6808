#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "tactile/events/event.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile {

/// Is handed one tick: its time, its heatmap ([height, width], valid until it returns) and the events in [t_c - t_h, t_c).
using TickCallback = std::function<void(CameraTime tick, std::span<const std::uint8_t> heatmap, std::uint64_t events_in_window)>;

/// Renders every full tick of a run, in order: those with t_c - t_h >= its first event's time and t_c <= its last event's.
///
/// @param events  the whole run's, ascending in time
/// @return        the ticks handed over, as `full_ticks` has them
/// @throws Error  if the events go back in time or lie outside the sensor, they come to over `most_ticks`, or as `check`
TickRange for_every_tick(std::span<const Event> events, SensorSize sensor, const HeatmapOptions& options,
                         const TickCallback& use);

/// The same from an event stream of a recording, packet by packet: memory follows the packet and the history.
/// @throws Error  also if the stream declares no size; where the list of packets tells of over `most_ticks`, before any is used
TickRange for_every_tick(RecordingReader& recording, std::int32_t stream_id, const HeatmapOptions& options,
                         const TickCallback& use);

/// The full ticks of an event stream as the recording's list of packets tells them, before any is read.
TickRange listed_ticks(const RecordingReader& recording, std::int32_t stream_id, const HeatmapOptions& options);

}  // namespace tactile
