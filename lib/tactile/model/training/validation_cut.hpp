#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/windows/sample.hpp"

namespace tactile::model {

/// Training and validation samples, as indexes of the given ones, ascending.
struct ValidationCut {
  std::vector<std::uint32_t> training, validation;
};

/// Divides samples by time: of each run and class the last `share` of the samples, rounded down, are for validation. Other
/// samples whose history overlaps that of a validation sample, of any class, are omitted, because neighbouring ticks have almost
/// the same heatmap.
///
/// @param samples  sorted by run, then time, as in a dataset
/// @param share    in [0, 1); 0: all samples are for training
/// @param history  t_h: samples of a run closer than this share events
ValidationCut cut_in_time(std::span<const windows::Sample> samples, double share, microseconds history);

}  // namespace tactile::model
