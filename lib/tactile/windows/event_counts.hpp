#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/pixel_mask.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::windows {

/// The number of events in [t_c - history, t_c) for samples of one run, as far as the dataset has events.
/// @param samples  indexes in the dataset, of this run
/// @param mask     pixels whose events do not count
std::vector<std::uint64_t> event_counts(const Dataset& dataset, std::uint32_t run, std::span<const std::uint32_t> samples,
                                        microseconds history, const events::MaskPixels& mask = {});

}  // namespace tactile::windows
