#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/windows/dataset_plan.hpp"
#include "tactile/windows/older_dataset.hpp"

namespace tactile::windows {

/// The name of the file that has a dataset's events.
std::string events_file_of(const std::filesystem::path& dataset);

/// Where the events of a plan's runs come from.
struct EventSources {
  const OlderDataset* older = nullptr;             ///< null: there is none
  std::vector<std::optional<std::uint32_t>> kept;  ///< for each run, that of `older` with the same events; else its recording
  microseconds history{};                          ///< the time before each sample of which events are stored
};

/// Writes a dataset's file of events, and the numbers of events to the plan's rows. The bytes do not depend on the threads.
/// @param file  a new one  @param manifest_hash  of the dataset  @return  the number of events  @throws UnusableDataset, Error
std::uint64_t write_events(DatasetPlan& plan, const EventSources& sources, const std::filesystem::path& file,
                           const std::string& manifest_hash, unsigned threads, const ProgressCallback& progress);

}  // namespace tactile::windows
