#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::model {

/// The features of samples of one run (`features::tick_features`), from the events that the dataset stores.
/// @param samples    indexes in the dataset, of this run, ascending
/// @param rendering  its history, tick and mask are used
/// @return  [samples, features::feature_count]
/// @throws Error  as `features::bin_of`, or if the dataset cannot be read
std::vector<float> sample_features(const windows::Dataset& dataset, std::uint32_t run, std::span<const std::uint32_t> samples,
                                   const heatmaps::HeatmapOptions& rendering);

/// The features of steps of samples of one run (`features::StepFeatures`), with the rendering's tick as step.
/// @return  [samples, features::step_values]
/// @throws Error  as `features::step_windows`, or if the dataset cannot be read
std::vector<float> sample_steps(const windows::Dataset& dataset, std::uint32_t run, std::span<const std::uint32_t> samples,
                                const heatmaps::HeatmapOptions& rendering);

}  // namespace tactile::model
