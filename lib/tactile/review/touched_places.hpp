#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::review {

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

/// The places of the picture that touches light: the cells whose common rate rises most clearly from quiet to the labelled
/// intervals.
///
/// Cells are taken by r = rise / quiet rate, the largest first, as long as Sum(rise) / sqrt(Sum(quiet)) grows: the rise of a sum
/// over its noise, which is that of counts. A cell's quiet rate is at least the mean of all cells: one that was quiet by chance
/// is not quieter than others.
class TouchedPlaces {
 public:
  /// @param size  not 0 x 0
  TouchedPlaces(events::SensorSize size, const labels::Labels& labels, CameraTime first, CameraTime last);

  void add(std::span<const events::Event> events);  ///< those outside the sensor do not count
  void choose();                                    ///< after the last event

  bool empty() const { return chosen_.empty(); }  ///< no interval, or no cell rises
  bool contains(const events::Event& event) const { return !empty() && is_in(event) && chosen_[cells_.at(event)]; }

 private:
  /// From here on until the next one.
  struct Part {
    CameraTime begin;
    enum class Kind : std::uint8_t { quiet, touched, neither } kind;
  };

  bool is_in(const events::Event& event) const {
    return event.x >= 0 && event.x < size_.width && event.y >= 0 && event.y < size_.height;
  }

  events::SensorSize size_;
  ImageCells cells_;
  std::vector<Part> parts_;
  double quiet_s_ = 0, touched_s_ = 0;
  std::vector<std::uint64_t> quiet_, touched_;  ///< events of each cell
  std::vector<bool> chosen_;
};

}  // namespace tactile::review
