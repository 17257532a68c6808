#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/windows/sample.hpp"

namespace tactile {

/// Samples to learn from and samples to judge by, as indexes into those given, ascending.
struct ValidationCut {
  std::vector<std::uint32_t> training, validation;
};

/// Cuts samples in time: of each run and class the last `share` of the samples, rounded down, are to judge by. Those of the rest
/// whose history shares time with one of these, of whatever class, are left out, for a tick's neighbours are all but the same
/// picture.
///
/// @param samples  by run, then time, as a dataset has them
/// @param share    in [0, 1); 0 leaves all to learn from
/// @param history  t_h: samples of a run closer than this share events
ValidationCut cut_in_time(std::span<const Sample> samples, double share, microseconds history);

}  // namespace tactile
