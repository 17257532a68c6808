#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/windows/dataset_plan.hpp"

namespace tactile::windows {

/// The events in the windows of run `run_index` during the recording of run `other_index`, and how many of them that recording
/// contains too: with the same time, pixel and polarity.
struct SharedEvents {
  std::uint32_t run_index = 0;
  std::uint32_t other_index = 0;
  std::uint64_t events = 0;
  std::uint64_t shared = 0;
};

/// Compares all pairs of recordings that overlap in camera time. Copies of a recording have the same events. Different recordings
/// may also overlap in camera time, because a clock restarted; by chance, a share of about (events per us and pixel) / 2 is
/// equal.
///
/// All recordings are read once, in common slices of camera time: memory follows the slice, run time the number of events.
///
/// @param history  the windows of a run are [t - history, t) of its samples
/// @return  both directions of each pair that overlaps in camera time, in order of `run_index`, then `other_index`
/// @throws Error  if a recording cannot be read
std::vector<SharedEvents> shared_events(std::span<const PlannedRun> runs, microseconds history, unsigned threads,
                                        const ProgressCallback& progress = {});

}  // namespace tactile::windows
