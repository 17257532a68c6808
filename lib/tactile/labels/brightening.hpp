#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/alignment/activity.hpp"
#include "tactile/alignment/event_rate.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::labels {

/// The image in square cells, row by row.
class ImageCells {
 public:
  /// @param cell_px  side of a cell; small against a marker, large enough to hold some events
  explicit ImageCells(events::SensorSize size, int cell_px = 8)
      : cell_px_(cell_px), columns_((size.width + cell_px - 1) / cell_px), rows_((size.height + cell_px - 1) / cell_px) {}
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  std::size_t count() const { return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_); }
  std::size_t at(const events::Event& event) const {
    return static_cast<std::size_t>(event.y / cell_px_) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(event.x / cell_px_);
  }

 private:
  int cell_px_, columns_, rows_;
};

/// What a touch changes in the picture: by cell, the number of its brighter events minus that of its darker ones.
using Brightening = std::vector<std::int32_t>;

/// Sum(a b) / sqrt(Sum(a a) Sum(b b)), -1 to 1; 0 if one of them is 0 everywhere. It is about 0, not about the means: cells
/// without brightening do not count.
double correlation_of(const Brightening& a, const Brightening& b);

void add(Brightening& sum, const Brightening& more);

/// Of each burst, in cells of 8 px. Reads the recording once.
/// @param rate    of the same stream of this recording
/// @param bursts  by time, nearly: an overlap costs time only
/// @throws Error  as reading events does
std::vector<Brightening> brightenings_of(events::RecordingReader& recording, std::int32_t stream_id,
                                         const alignment::EventRate& rate, std::span<const alignment::Burst> bursts);

}  // namespace tactile::labels
