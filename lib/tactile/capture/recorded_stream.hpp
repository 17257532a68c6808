#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tactile/capture/camera_source.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::capture {

/// One stream of a run's recording, and its source.
struct RecordedStream {
  events::Stream stream;           ///< as the recording declares it; its id is its index
  std::size_t source_index = 0;    ///< among the sources
  std::int32_t source_stream = 0;  ///< its id in the source
};

/// The streams of all sources with a known type: events first, then IMU, triggers and frames. Attributes that a recording must
/// declare are added.
/// @throws Error  if no source has a stream of events, or two sources have the same stream of the same camera
std::vector<RecordedStream> recorded_streams(std::span<const std::unique_ptr<CameraSource>> sources);

}  // namespace tactile::capture
