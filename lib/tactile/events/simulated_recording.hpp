#pragma once

#include <span>
#include <string_view>

#include "tactile/core/run_folder.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::events {

inline constexpr std::string_view simulated_attribute = "simulated";  ///< in a stream's `info`: "true" if it was simulated

/// Whether a simulator made these streams: one has the attribute, or its camera is the simulator's, "DVXplorer_SIM00001".
bool is_simulated(std::span<const Stream> streams);

/// Whether the run was simulated: run.json says so; or there is no run.json, but a truth.json; or the camera of the recording is
/// the simulator's. Reads only the recording's header. @throws Error  if run.json cannot be read
bool is_simulated(const RunFolder& run);

}  // namespace tactile::events
