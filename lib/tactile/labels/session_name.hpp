#pragma once

#include <optional>
#include <string>

#include "tactile/events/recording_reader.hpp"

namespace tactile::labels {

/// The session of a recording whose run.json names none: "camera started at ...", by the start of the camera, which DV notes as
/// `tsOffset` in each recording. Nothing if another program recorded. @throws Error  if there is not one event stream
std::optional<std::string> camera_session_of(const events::RecordingReader& recording);

}  // namespace tactile::labels
