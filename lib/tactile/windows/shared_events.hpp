#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/windows/dataset_plan.hpp"

namespace tactile {

/// The events in the windows of `run_index` that lie in the camera time of the recording of `other_index`, and how many of them
/// that recording holds too: of the same time, pixel and polarity.
struct SharedEvents {
  std::uint32_t run_index = 0;
  std::uint32_t other_index = 0;
  std::uint64_t events = 0;
  std::uint64_t shared = 0;
};

/// Compares every two recordings that overlap in camera time, where they do. Events of one recording stay the same ones in each
/// file that holds them; two recordings whose camera times overlap since a clock began anew have a few equal ones by chance,
/// about (events per us and pixel) / 2 of them.
///
/// All recordings are gone through once, side by side in slices of camera time: memory follows the slice, work the events.
///
/// @param history  the windows of a run are [t - history, t) of its samples
/// @return  both ways for each pair that overlaps in camera time, in order of `run_index`, then `other_index`
/// @throws Error  if a recording cannot be read
std::vector<SharedEvents> shared_events(std::span<const PlannedRun> runs, microseconds history, unsigned threads,
                                        const ProgressCallback& progress = {});

}  // namespace tactile
