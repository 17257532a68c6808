#pragma once

#include <nlohmann/json.hpp>

#include "tactile/events/recording_reader.hpp"

namespace tactile::cli {

/// The problems of a recording by name, with counts.
nlohmann::json json_of(const events::RecordingProblems& problems);

}  // namespace tactile::cli
