#pragma once

#include <span>
#include <string_view>

#include "tactile/core/run_folder.hpp"
#include "tactile/events/stream.hpp"

namespace tactile {

inline constexpr std::string_view simulated_attribute = "simulated";  ///< of a stream's `info`: "true" of what no camera ever saw

/// Whether no camera ever saw these streams: one says so, or is of a camera of the simulator, "DVXplorer_SIM00001".
bool is_simulated(std::span<const Stream> streams);

/// Whether the run was simulated: run.json says so, or without one truth.json lies there, or the recording's camera is one of the
/// simulator. @throws Error  if there is a run.json that cannot be read
bool is_simulated(const RunFolder& run);

}  // namespace tactile
