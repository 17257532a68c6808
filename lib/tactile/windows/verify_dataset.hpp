#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"

namespace tactile {

struct DatasetCheck {
  std::vector<std::string> differences;  ///< a sentence each; none if the dataset holds
  std::uint64_t pairs_at_one_time = 0;   ///< pairs of runs whose recordings overlap in camera time, compared event by event
  std::uint64_t equal_by_chance = 0;     ///< events of windows that equal one of another run; too few to be the same ones
};

/// Derives the dataset again from the runs below `data`, by the settings it was made with, and compares: runs, sensor, intervals,
/// samples and events.
///
/// Splits are by run. So no event of a training window lies in a test window, whatever the split, if no event of any window of
/// a run is in the recording of another: that is shown too, event by event where recordings overlap in camera time, as
/// `shared_events` counts them, and by the hashes of the files. More than 1 in 100 counts as shared.
///
/// @param threads  0: as many as the machine has cores
/// @throws Error  if there is no dataset, or a run cannot be read
DatasetCheck verify_dataset(const std::filesystem::path& data, const std::filesystem::path& file, unsigned threads = 0,
                            const ProgressCallback& progress = {});

}  // namespace tactile
