#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::heatmaps {

/// The memory for one rendering of sample i: [height, width] bytes.
using HeatmapPlace = std::function<std::span<std::uint8_t>(std::size_t rendering_index, std::size_t i)>;

/// The next events of a run, ascending in time; empty at its end.
using NextEvents = std::function<std::vector<events::Event>()>;

/// Renders the moments of a run from any events, piece by piece. Memory follows the piece.
///
/// @param times     ascending
/// @param place_of  as of `render_run`, for times[i]
/// @throws Error    as HeatmapRenderer
void render_events(events::SensorSize sensor, const NextEvents& next, std::span<const HeatmapOptions> renderings,
                   std::span<const CameraTime> times, const HeatmapPlace& place_of);

/// Renders samples of one run with several settings, in one pass over the events that the dataset stores.
///
/// @param sample_indexes  into `dataset.samples()`, all of that run, ascending; repeated or not
/// @param place_of        returns the memory for sample_indexes[i] with renderings[rendering_index]; called sample by sample
/// @throws Error  as `check`
void render_run(const windows::Dataset& dataset, std::uint32_t run_index, std::span<const HeatmapOptions> renderings,
                std::span<const std::uint32_t> sample_indexes, const HeatmapPlace& place_of);

/// Renders the heatmaps of a dataset's samples from its stored events, in parallel over its runs. The bytes do not depend on
/// `threads` or on the other samples.
///
/// @param sample_indexes  into `dataset.samples()`, in any order, repeated or not
/// @param threads         0: one per core
/// @return  [sample_indexes, height, width] of `heatmap_size(dataset.sensor(), options.factor)`
/// @throws Error  if an index lies outside the samples, the history is longer than the dataset stores, a sample's time is not a
///                tick of `options`, or as `check`
std::vector<std::uint8_t> render_samples(const windows::Dataset& dataset, const HeatmapOptions& options,
                                         std::span<const std::uint32_t> sample_indexes, unsigned threads = 0,
                                         const ProgressCallback& progress = {});

/// @throws Error  as `render_samples` would for any sample of the dataset
void check_renders(const windows::Dataset& dataset, const HeatmapOptions& options);

}  // namespace tactile::heatmaps
