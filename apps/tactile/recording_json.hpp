#pragma once

#include <nlohmann/json.hpp>

#include "tactile/events/recording_reader.hpp"

namespace tactile {

/// The counts of what was wrong with a recording, by name.
nlohmann::json json_of(const RecordingProblems& problems);

}  // namespace tactile
