#pragma once

#include <filesystem>

#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/repair.hpp"

namespace tactile {

/// Makes a whole run of one that was cut off or damaged: the recording repaired, the logs up to the first zero byte, which a
/// power cut leaves, the other files of a run as they are, and run.json with `complete: true`, the files' hashes and, under
/// `repaired`, what was lost. Labels stay behind, for they are of other bytes. `out` appears only once it is whole.
/// @param out  `DATA/<object>/<run>`, a run's folder that is not there yet
/// @param threads  to read on, > 0
/// @throws Error  if `out` is there or no run's name, run.json cannot be read, or the recording cannot be repaired
RepairSummary repair_run(const RunFolder& in, const std::filesystem::path& out, unsigned threads = 1,
                         const ProgressCallback& progress = {});

}  // namespace tactile
