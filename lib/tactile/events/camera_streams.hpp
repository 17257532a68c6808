#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "tactile/events/stream.hpp"

namespace tactile::events {

/// Whether a stream is `events` itself, or one of its camera that has no events, or one without a camera's name.
inline bool belongs_to(const Stream& stream, const Stream& events) {
  if (stream.type == StreamType::events) return stream.id == events.id;
  return stream.source.empty() || stream.source == events.source;
}

/// The streams that belong to `events`; all of a recording if no other stream has events.
inline std::vector<Stream> camera_streams(std::span<const Stream> all, const Stream& events) {
  std::vector<Stream> streams(all.begin(), all.end());
  const auto has_events = [](const Stream& stream) { return stream.type == StreamType::events; };
  if (std::count_if(all.begin(), all.end(), has_events) > 1)
    std::erase_if(streams, [&](const Stream& stream) { return !belongs_to(stream, events); });
  return streams;
}

}  // namespace tactile::events
