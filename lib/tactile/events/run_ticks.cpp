#include "tactile/events/run_ticks.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "tactile/core/error.hpp"

namespace tactile::events {
namespace {

constexpr std::size_t chunk = 8192;  // at most this many events are given before the tick that they fill

/// Receives the events of a run, and passes on each full tick as soon as an event at or after it proves that it is full.
class EveryTick {
 public:
  /// @param where  the start of the error for too many ticks
  EveryTick(microseconds history, microseconds tick, const TickFollower& follower, const ChangeEvents& change,
            std::string where = {})
      : history_(history), follower_(follower), change_(change), where_(std::move(where)) {
    range_.tick = tick;
  }

  void add(std::span<const Event> events) {
    for (; !events.empty(); events = events.subspan(std::min(chunk, events.size()))) {
      const std::span<const Event> part = events.first(std::min(chunk, events.size()));
      if (!first_event_) first_event_ = part.front().t;
      last_event_ = part.back().t;
      add_changed(change_ ? change_(part, false) : part);
    }
  }

  void finish() {
    if (!change_ || !first_event_) return;
    add_changed(change_({}, true));
    follow_until(last_event_);
  }

  TickRange range() const { return range_; }

 private:
  /// Later changed events lie at or after the last of these, so ticks until then are full.
  void add_changed(std::span<const Event> events) {
    for (; !events.empty(); events = events.subspan(std::min(chunk, events.size()))) {
      const std::span<const Event> part = events.first(std::min(chunk, events.size()));
      follower_.add(part);
      follow_until(std::min(part.back().t, last_event_));
    }
  }

  void follow_until(CameraTime last_event) {
    const TickRange full = full_ticks(*first_event_, last_event, history_, range_.tick);
    if (const std::string why = why_too_many(full); !why.empty()) throw Error(where_ + why);
    if (full.count > 0) range_.first = full.first;
    for (; range_.count < full.count; ++range_.count) follower_.tick(full.at(range_.count));
  }

  microseconds history_;
  const TickFollower& follower_;
  const ChangeEvents& change_;
  std::string where_;
  std::optional<CameraTime> first_event_;
  CameraTime last_event_{};
  TickRange range_;
};

}  // namespace

TickRange follow_ticks(std::span<const Event> events, microseconds history, microseconds tick, const TickFollower& follower) {
  const ChangeEvents unchanged;
  EveryTick ticks(history, tick, follower, unchanged);
  ticks.add(events);
  return ticks.range();
}

TickRange follow_ticks(RecordingReader& recording, std::int32_t stream_id, microseconds history, microseconds tick,
                       const TickFollower& follower, const ChangeEvents& change) {
  if (const std::string why = why_too_many(listed_ticks(recording, stream_id, history, tick)); !why.empty())
    throw Error(recording.file().string() + ": " + why);
  EveryTick ticks(history, tick, follower, change, recording.file().string() + ": ");
  for_all_events(recording, stream_id, [&](std::span<const Event> events) { ticks.add(events); });
  ticks.finish();
  return ticks.range();
}

TickRange listed_ticks(const RecordingReader& recording, std::int32_t stream_id, microseconds history, microseconds tick) {
  std::optional<CameraTime> first, last;
  for (const PacketRecord& packet : recording.packets()) {
    if (packet.stream_id != stream_id || packet.elements == 0) continue;
    first = std::min(first.value_or(packet.first), packet.first);
    last = std::max(last.value_or(packet.last), packet.last);
  }
  return first ? full_ticks(*first, *last, history, tick) : TickRange{.first = {}, .count = 0, .tick = tick};
}

}  // namespace tactile::events
