#pragma once

#include <filesystem>

#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/repair.hpp"

namespace tactile::events {

/// Makes a complete run of a damaged one. The recording is repaired. Logs are copied up to the first zero byte, which a power cut
/// leaves. The other files are copied as they are. run.json has `complete: true`, the hashes of the files and, under `repaired`,
/// what was lost. Labels are not copied, because they belong to the old bytes. `out` appears only when it is complete.
/// @param out  `DATA/<object>/<run>`, a folder that does not exist yet
/// @param threads  threads that read, > 0
/// @throws Error  if `out` exists or is not a run's name, run.json cannot be read, or the recording cannot be repaired
RepairSummary repair_run(const RunFolder& in, const std::filesystem::path& out, unsigned threads = 1,
                         const ProgressCallback& progress = {});

}  // namespace tactile::events
