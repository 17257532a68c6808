#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tactile/windows/dataset.hpp"

namespace tactile::windows {

/// The samples of a run, which follow one another in a dataset.
struct RunSamples {
  std::uint32_t run_index = 0;
  std::uint32_t first = 0;  ///< index into `Dataset::samples`
  std::uint32_t count = 0;  ///< > 0
};

/// Runs without samples have no entry.
std::vector<RunSamples> samples_by_run(const Dataset& dataset);

/// Identifies what the heatmaps of these samples are rendered from: SHA-256 of the JSON text, with sorted keys and without white
/// space, of `events_sha256`, `sensor` ({"height", "width"}) and `t_us`, the samples' times. Equal hashes and equal settings of
/// the rendering give equal heatmaps.
std::string source_sha256_of(const Dataset& dataset, const RunSamples& run);

}  // namespace tactile::windows
