#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tactile/capture/camera_source.hpp"
#include "tactile/events/stream.hpp"

namespace tactile {

/// One stream of a run's recording, and where it comes from.
struct RecordedStream {
  Stream stream;                   ///< as the recording declares it; its id is its index among all of them
  std::size_t source_index = 0;    ///< among the sources
  std::int32_t source_stream = 0;  ///< the source's own id of it
};

/// The streams of all sources but those of other types: events first, then IMU, triggers and frames, with what a recording must
/// declare filled in.
/// @throws Error  if no source has a stream of events, or two sources have the same stream of the same camera
std::vector<RecordedStream> recorded_streams(std::span<const std::unique_ptr<CameraSource>> sources);

}  // namespace tactile
