#include "tactile/heatmaps/run_heatmaps.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"

namespace tactile::heatmaps {
namespace {

constexpr std::size_t chunk = 8192;  // at most so many events are counted before their tick is rendered

/// Receives the events of a run, and passes on each full tick as soon as an event at or after it proves that it is full.
class EveryTick {
 public:
  /// @param where  the begin of the error for too many ticks
  EveryTick(events::SensorSize sensor, const HeatmapOptions& options, const TickCallback& use, const ChangeEvents& change,
            std::string where = {})
      : options_(options), use_(use), change_(change), where_(std::move(where)), renderer_(sensor, options) {
    heatmap_.resize(static_cast<std::size_t>(renderer_.size().width) * static_cast<std::size_t>(renderer_.size().height));
    range_.tick = options.tick;
  }

  void add(std::span<const events::Event> events) {
    for (; !events.empty(); events = events.subspan(std::min(chunk, events.size()))) {
      const std::span<const events::Event> part = events.first(std::min(chunk, events.size()));
      if (!first_event_) first_event_ = part.front().t;
      last_event_ = part.back().t;
      add_changed(change_ ? change_(part, false) : part);
    }
  }

  void finish() {
    if (!change_ || !first_event_) return;
    add_changed(change_({}, true));
    render_until(last_event_);
  }

  TickRange range() const { return range_; }

 private:
  /// Later changed events lie at or after the last of these, so ticks until then are full.
  void add_changed(std::span<const events::Event> events) {
    for (; !events.empty(); events = events.subspan(std::min(chunk, events.size()))) {
      const std::span<const events::Event> part = events.first(std::min(chunk, events.size()));
      renderer_.add(part);
      render_until(std::min(part.back().t, last_event_));
    }
  }

  void render_until(CameraTime last_event) {
    const TickRange full = full_ticks(*first_event_, last_event, options_.history, options_.tick);
    if (const std::string why = why_too_many(full); !why.empty()) throw Error(where_ + why);
    if (full.count > 0) range_.first = full.first;
    for (; range_.count < full.count; ++range_.count) {
      const CameraTime t = full.at(range_.count);
      renderer_.move_to(t);
      renderer_.render(std::span(heatmap_));
      use_(t, heatmap_, renderer_.events());
    }
  }

  HeatmapOptions options_;
  const TickCallback& use_;
  const ChangeEvents& change_;
  std::string where_;
  HeatmapRenderer renderer_;
  std::vector<std::uint8_t> heatmap_;
  std::optional<CameraTime> first_event_;
  CameraTime last_event_{};
  TickRange range_;
};

}  // namespace

TickRange for_every_tick(std::span<const events::Event> events, events::SensorSize sensor, const HeatmapOptions& options,
                         const TickCallback& use) {
  const ChangeEvents unchanged;
  EveryTick ticks(sensor, options, use, unchanged);
  ticks.add(events);
  return ticks.range();
}

TickRange for_every_tick(events::RecordingReader& recording, std::int32_t stream_id, const HeatmapOptions& options,
                         const TickCallback& use, const ChangeEvents& change) {
  const std::optional<events::SensorSize> sensor = recording.stream(stream_id).size;
  if (!sensor)
    throw Error(recording.file().string() + ": stream " + std::to_string(stream_id) + " declares no size; expected its sensor's");
  if (const std::string why = why_too_many(listed_ticks(recording, stream_id, options)); !why.empty())
    throw Error(recording.file().string() + ": " + why);
  EveryTick ticks(*sensor, options, use, change, recording.file().string() + ": ");
  events::for_all_events(recording, stream_id, [&](std::span<const events::Event> events) { ticks.add(events); });
  ticks.finish();
  return ticks.range();
}

TickRange listed_ticks(const events::RecordingReader& recording, std::int32_t stream_id, const HeatmapOptions& options) {
  std::optional<CameraTime> first, last;
  for (const events::PacketRecord& packet : recording.packets()) {
    if (packet.stream_id != stream_id || packet.elements == 0) continue;
    first = std::min(first.value_or(packet.first), packet.first);
    last = std::max(last.value_or(packet.last), packet.last);
  }
  return first ? full_ticks(*first, *last, options.history, options.tick)
               : TickRange{.first = {}, .count = 0, .tick = options.tick};
}

}  // namespace tactile::heatmaps
