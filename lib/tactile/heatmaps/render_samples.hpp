#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

/// Where to render a sample by one of several ways: [height, width] bytes.
using HeatmapPlace = std::function<std::span<std::uint8_t>(std::size_t way_index, std::size_t i)>;

/// Renders samples of one run, by several ways at once in one pass over the events that the dataset stores.
///
/// @param sample_indexes  into `dataset.samples()`, all of that run, ascending; repeated or not
/// @param place_of        is asked for the place of sample_indexes[i] by ways[way_index], sample by sample
/// @throws Error  as `check`
void render_run(const Dataset& dataset, std::uint32_t run_index, std::span<const HeatmapOptions> ways,
                std::span<const std::uint32_t> sample_indexes, const HeatmapPlace& place_of);

/// Renders the heatmaps of a dataset's samples from the events it stores, in parallel over its runs; the bytes do not depend on
/// `threads`, nor on which other samples are asked for.
///
/// @param sample_indexes  into `dataset.samples()`, in any order, repeated or not
/// @param threads         0: as many as the machine has cores
/// @return  [sample_indexes, height, width] of `heatmap_size(dataset.sensor(), options.factor)`, one after the other
/// @throws Error  if an index lies outside the samples, the history is longer than the dataset stores, a sample lies at no
///                tick of `options`, or as `check`
std::vector<std::uint8_t> render_samples(const Dataset& dataset, const HeatmapOptions& options,
                                         std::span<const std::uint32_t> sample_indexes, unsigned threads = 0,
                                         const ProgressCallback& progress = {});

/// @throws Error  as `render_samples` would for any sample of the dataset
void check_renders(const Dataset& dataset, const HeatmapOptions& options);

}  // namespace tactile
