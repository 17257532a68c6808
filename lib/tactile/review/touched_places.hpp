#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/labels/brightening.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::review {

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
  labels::ImageCells cells_;
  std::vector<Part> parts_;
  double quiet_s_ = 0, touched_s_ = 0;
  std::vector<std::uint64_t> quiet_, touched_;  ///< events of each cell
  std::vector<bool> chosen_;
};

}  // namespace tactile::review
