#pragma once

#include <optional>
#include <string>

#include "tactile/events/stream.hpp"

namespace tactile::labels {

/// The session of a recording whose run.json names none: "camera started at ...", by the start of the camera, which DV notes as
/// `tsOffset` in each recording. Nothing if another program recorded.
/// @param stream  its event stream
std::optional<std::string> camera_session_of(const events::Stream& stream);

}  // namespace tactile::labels
