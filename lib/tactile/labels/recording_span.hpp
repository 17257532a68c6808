#pragma once

#include "tactile/core/run_folder.hpp"
#include "tactile/core/time.hpp"

namespace tactile::labels {

/// The first and the last event of a run's recording.
struct RecordingSpan {
  CameraTime first{}, last{};
};

/// @throws Error  if the recording cannot be read or has no event
RecordingSpan span_of_events(const RunFolder& run);

}  // namespace tactile::labels
