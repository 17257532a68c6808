#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"

namespace tactile::windows {

struct DatasetCheck {
  std::vector<std::string> differences;  ///< a sentence each; empty if the dataset is correct
  std::uint64_t pairs_at_one_time = 0;   ///< pairs of runs whose recordings overlap in camera time, compared event by event
  std::uint64_t equal_by_chance = 0;     ///< events in windows equal to one of another run, too few to be shared
  std::vector<std::string> histories;    ///< listed ones whose values are all intact
};

/// Derives the dataset again from the runs below `data`, with the settings it was made with, and compares runs, sensor,
/// intervals, samples and events. It compares the values of each listed history with their stored hash.
///
/// It also checks that training and test windows share no event, whatever the split. Splits are by run, so this holds if no event
/// in a window of a run is in the recording of another run. Recordings that overlap in camera time are compared event by event
/// (`shared_events`), and all files by their hash. More than 1 in 100 events counts as shared.
///
/// @param threads  0: one per core
/// @throws Error  if there is no dataset, or there are no runs
DatasetCheck verify_dataset(const std::filesystem::path& data, const std::filesystem::path& file, unsigned threads = 0,
                            const ProgressCallback& progress = {});

}  // namespace tactile::windows
