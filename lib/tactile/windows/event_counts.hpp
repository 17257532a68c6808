#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/windows/dataset.hpp"

namespace tactile {

/// How many events lie in [t_c - history, t_c) of samples of one run, as far as the dataset holds events.
/// @param samples  of this run, by their index in the dataset
std::vector<std::uint64_t> event_counts(const Dataset& dataset, std::uint32_t run, std::span<const std::uint32_t> samples,
                                        microseconds history);

}  // namespace tactile
