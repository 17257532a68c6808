#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/waiting_events.hpp"
#include "tactile/features/event_sums.hpp"

namespace tactile::features {

/// Sums over the events of a history that slides along a recording, in bins of equal length:
///
///   bin k of a tick t = the events with t - t_h + k b <= time < t - t_h + (k + 1) b
///
/// An event is added to its bin once. It leaves with the whole bin, so nothing is subtracted and no sum drifts. Cost: a few ns
/// for each event, and about 3 KB of memory to clear for each bin. Memory is allocated only if more events wait than ever before.
class SlidingSums {
 public:
  static constexpr std::int64_t most_bins = 4096;

  /// @param history  t_h, a whole number of bins, at most `most_bins`
  /// @param bin      b; ticks are whole multiples of it
  /// @param mask     pixels whose events do not count
  /// @throws Error   if the sensor has no area, or these are out of their ranges
  SlidingSums(events::SensorSize sensor, microseconds history, microseconds bin, const events::MaskPixels& mask = {});

  /// Appends events, ascending in time and not before earlier ones. They are counted by `move_to`.
  /// @throws Error  if they go back in time or lie outside the sensor; then none of them is added
  void add(std::span<const events::Event> events) { waiting_.add(events); }

  /// Moves the history to [t - t_h, t); later events wait. Events that are added afterwards and lie in it are counted by the next
  /// call, which may be for the same t. @throws Error  if `t` is before the last one, or is no whole number of bins
  void move_to(CameraTime t);

  std::uint64_t events() const;  ///< in the history
  std::size_t bins() const { return bins_.size(); }
  EventSums sum(std::size_t first, std::size_t count) const;  ///< of bins [first, first + count), count > 0
  const EventSums& bin(std::size_t k) const { return bins_[(front_ + k) % bins_.size()]; }  ///< the oldest is 0

 private:
  void count(const events::Event& event);

  microseconds history_, bin_;
  events::WaitingEvents waiting_;
  std::vector<std::uint16_t> column_of_, row_of_;  ///< the cell of a pixel is the sum of both
  std::vector<EventSums> bins_;                    ///< a ring
  std::size_t front_ = 0;
  CameraTime tick_ = CameraTime::min();
};

}  // namespace tactile::features
