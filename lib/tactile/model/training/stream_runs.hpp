#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/inference/stream_counts.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::model {

/// The events of a tick as a training keeps them: an image of each polarity. Its rows are those of the cells. A cell has `fine`
/// of its columns, so that a picture can be moved by less than a cell.
struct StreamImage {
  static constexpr std::size_t fine = 3;
  static constexpr std::size_t rows = StreamLayout::all_rows, columns = fine * StreamLayout::all_columns;
  static constexpr std::size_t size = 2 * rows * columns;  ///< [polarity, row, column]

  static constexpr std::size_t at(std::size_t polarity, std::size_t row, std::size_t column) {
    return (polarity * rows + row) * columns + column;
  }
};

/// A touch of a training run, in ticks of the run: [begin, end).
struct TickSpan {
  Touch touch = Touch::none;
  std::size_t begin = 0, end = 0;
};

/// A whole run, as a network of kind `stream` learns from it.
struct StreamRun {
  std::string name;  ///< "fan/01"
  std::size_t ticks = 0;
  std::vector<std::uint8_t> counts;  ///< [tick, StreamImage::size], at most 255
  std::vector<Touch> truth;          ///< of each tick
  std::vector<float> weights;        ///< of each tick in the loss
  std::vector<TickSpan> touches;     ///< labelled, by time

  std::span<const std::uint8_t> at(std::size_t tick) const {
    return std::span(counts).subspan(tick * StreamImage::size, StreamImage::size);
  }
};

/// The rectangle that holds the events of the labelled touches of these runs, except for the outermost 1 % on each side.
StreamGrid grid_of_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> runs, const events::MaskPixels& mask);

/// Reads whole runs and their labels. A tick weighs 3 in the first 40 ms of a touch, 2 in motion of no sure class (releases), 0
/// from 20 ms before to 50 ms after the end of a touch and in a touch whose labels are in doubt, else 1.
/// @throws Error  if a recording or its labels cannot be read, or are not those of the dataset
std::vector<StreamRun> stream_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> runs, const StreamGrid& grid,
                                   const heatmaps::HeatmapOptions& rendering, unsigned threads,
                                   const ProgressCallback& progress = {});

}  // namespace tactile::model
