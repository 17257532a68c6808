#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "events/aedat4_bytes.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::test {

inline const events::Stream mini = events::event_stream_declaration({640, 480}, "DVXplorer_DXM00001");

inline events::Stream other_stream(std::int32_t id, events::StreamType type, const std::string& name) {
  events::Stream stream;
  stream.id = id;
  stream.type = type;
  stream.name = name;
  stream.source = "DVXplorer_DXM00001";
  if (type == events::StreamType::frames) stream.size = events::SensorSize{640, 480};
  return stream;
}

/// Events at random places and random, never falling times.
inline std::vector<events::Event> random_events(std::uint64_t seed, std::size_t count, std::int64_t begin,
                                                std::uint64_t most_gap_us) {
  Random random(seed);
  std::vector<events::Event> events;
  std::int64_t t = begin;
  for (std::size_t i = 0; i < count; ++i) {
    t += static_cast<std::int64_t>(random.below(most_gap_us + 1));
    events.push_back(
        event(t, static_cast<int>(random.below(640)), static_cast<int>(random.below(480)), static_cast<int>(random.below(2))));
  }
  return events;
}

}  // namespace tactile::test
