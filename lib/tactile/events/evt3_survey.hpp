#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/evt3.hpp"

namespace tactile::events {

/// What a part of an EVT3 stream holds.
struct Evt3Survey {
  std::int64_t events = 0;
  CameraTime first{}, last{};  ///< earliest and latest of them; meaningless without events
};

/// Counts the events of `data`, and leaves the decoder as if it had decoded them. It makes no event, so it is several times as
/// fast. @param data  whole words  @param triggers  are appended
Evt3Survey survey(Evt3Decoder& decoder, SensorSize size, std::span<const std::byte> data, std::vector<Evt3Trigger>& triggers);

}  // namespace tactile::events
