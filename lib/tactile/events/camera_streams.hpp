#pragma once

#include "tactile/events/stream.hpp"

namespace tactile::events {

/// Whether a stream is `events` itself, or one of its camera that has no events, or one without a camera's name.
inline bool belongs_to(const Stream& stream, const Stream& events) {
  if (stream.type == StreamType::events) return stream.id == events.id;
  return stream.source.empty() || stream.source == events.source;
}

}  // namespace tactile::events
