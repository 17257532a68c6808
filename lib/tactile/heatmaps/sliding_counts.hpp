#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"

namespace tactile {

/// Events per pixel over a history that slides along a recording:
///
///   E(x, y) = number of events with t_c - t_h <= t < t_c at the pixel, either polarity
///
/// Adding and removing cost as much as there are events, never as much as there are pixels.
class SlidingCounts {
 public:
  /// @param history  t_h > 0
  /// @throws Error  if the sensor has no area or more than 2^26 pixels, or the history is not positive
  SlidingCounts(SensorSize size, microseconds history);

  /// Appends events not yet counted, ascending in time and none before those already given.
  /// @throws Error  if they go back in time or lie outside the sensor
  void add(std::span<const Event> events);

  /// Moves the window to [t_c - t_h, t_c): counts the events given up to there, forgets those before it; later events wait.
  /// @throws Error  if `tick` lies before the one last moved to
  void move_to(CameraTime tick);

  SensorSize size() const { return size_; }
  std::uint64_t events() const { return in_window_; }                    ///< counted now
  std::uint32_t at(int x, int y) const { return counts_[index(x, y)]; }  ///< E(x, y)
  std::span<const std::uint32_t> counts() const { return counts_; }      ///< [height, width], row by row

  /// The indexes into `counts` of every pixel with E > 0, each once, in no order.
  std::span<const std::uint32_t> active() const { return active_; }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(x);
  }
  void count(std::uint32_t pixel);
  void forget(std::uint32_t pixel);

  struct Waiting {
    CameraTime t;
    std::uint32_t pixel;
  };
  SensorSize size_;
  microseconds history_;
  std::vector<std::uint32_t> counts_;
  std::vector<std::uint32_t> active_;
  std::vector<std::uint32_t> place_in_active_;  // of a pixel with E > 0
  std::deque<Waiting> waiting_;                 // given and not yet forgotten
  std::size_t counted_ = 0;                     // of `waiting_`, from its front
  std::uint64_t in_window_ = 0;
  CameraTime tick_ = CameraTime::min();
  CameraTime last_ = CameraTime::min();  // of the events given
};

}  // namespace tactile
