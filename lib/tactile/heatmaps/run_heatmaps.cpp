#include "tactile/heatmaps/run_heatmaps.hpp"

#include <optional>
#include <string>
#include <vector>

#include "tactile/core/error.hpp"

namespace tactile::heatmaps {
namespace {

/// Renders the heatmap of each tick.
struct Rendering {
  HeatmapRenderer renderer;
  const TickCallback& use;
  std::vector<std::uint8_t> heatmap{};

  events::TickFollower follower() {
    heatmap.resize(static_cast<std::size_t>(renderer.size().width) * static_cast<std::size_t>(renderer.size().height));
    return {[this](std::span<const events::Event> events) { renderer.add(events); },
            [this](CameraTime t) {
              renderer.move_to(t);
              renderer.render(std::span(heatmap));
              use(t, heatmap, renderer.events());
            }};
  }
};

}  // namespace

TickRange for_every_tick(std::span<const events::Event> events, events::SensorSize sensor, const HeatmapOptions& options,
                         const TickCallback& use) {
  Rendering rendering{HeatmapRenderer(sensor, options), use};
  return events::follow_ticks(events, options.history, options.tick, rendering.follower());
}

TickRange for_every_tick(events::RecordingReader& recording, std::int32_t stream_id, const HeatmapOptions& options,
                         const TickCallback& use, const ChangeEvents& change) {
  const std::optional<events::SensorSize> sensor = recording.stream(stream_id).size;
  if (!sensor)
    throw Error(recording.file().string() + ": stream " + std::to_string(stream_id) + " declares no size; expected its sensor's");
  Rendering rendering{HeatmapRenderer(*sensor, options), use};
  return events::follow_ticks(recording, stream_id, options.history, options.tick, rendering.follower(), change);
}

TickRange listed_ticks(const events::RecordingReader& recording, std::int32_t stream_id, const HeatmapOptions& options) {
  return events::listed_ticks(recording, stream_id, options.history, options.tick);
}

}  // namespace tactile::heatmaps
