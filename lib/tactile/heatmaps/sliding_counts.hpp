#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/heatmaps/cell_counts.hpp"
#include "tactile/heatmaps/count_histogram.hpp"

namespace tactile::heatmaps {

/// Events per pixel over a history that slides along a recording:
///
///   E(x, y) = number of events with t_c - t_h <= t < t_c at the pixel, either polarity
///
/// and the number of pixels with each count, in the whole image and in each cell of a grid. Adding and removing cost time in
/// proportion to the events, not to the pixels. Memory is allocated only if the window, or a pixel, has more events than ever
/// before.
class SlidingCounts {
 public:
  /// @param history  t_h > 0
  /// @param grid     for the same sensor; by default no pixel belongs to a cell
  /// @throws Error  if the sensor has no area, more than 2^26 pixels or more than 2^15 in a direction, or the history is not
  /// positive
  SlidingCounts(events::SensorSize size, microseconds history, const CellGrid& grid = {});

  /// Appends events, ascending in time and not before earlier ones. They are counted by `move_to`.
  /// @throws Error  if they go back in time or lie outside the sensor; then none of them is added
  void add(std::span<const events::Event> events);

  /// Moves the window to [t_c - t_h, t_c): counts the events in it and drops those before it; later events wait.
  /// @throws Error  if `tick` is before the last one
  void move_to(CameraTime tick);

  events::SensorSize size() const { return size_; }
  std::uint64_t events() const { return counted_; }  ///< in the window

  /// E(x, y)
  std::uint32_t at(int x, int y) const {
    const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(x);
    return small_counts_[pixel] < large ? small_counts_[pixel] : large_counts_[pixel];
  }

  static constexpr std::uint16_t large = CellCounts<std::uint8_t>::count_limit - 1;
  std::span<const std::uint16_t> small_counts() const { return small_counts_; }  ///< [height, width] min(E, large)
  const CountHistogram& histogram() const { return histogram_; }                 ///< the number of pixels with each E

  // One byte is enough for the numbers of a cell with at most 15 x 15 pixels.
  using Cells = std::variant<CellCounts<std::uint8_t>, CellCounts<std::uint32_t>>;
  Cells& cells() { return cells_; }

 private:
  struct Waiting {
    CameraTime t;
    std::uint32_t pixel;
    std::uint32_t place;  // of its cell's numbers
  };
  const Waiting& waiting(std::size_t index) const { return ring_[(front_ + index) & (capacity_ - 1)]; }
  std::size_t waiting_before(CameraTime t, std::size_t from, std::size_t to) const;
  void make_room(std::size_t events);
  template <int by>
  void change_counts(std::size_t from, std::size_t to);
  template <int by, class AnyCells>
  std::uint32_t change_counts_of(std::span<const Waiting> events, AnyCells& cells);
  void update_histogram();
  [[gnu::noinline]] void change_high_count(std::uint32_t pixel, int by);

  events::SensorSize size_;
  microseconds history_;
  std::vector<std::uint16_t> small_counts_;  // small, to stay in the cache
  std::vector<std::uint32_t> large_counts_;  // of pixels whose small count is `large`
  CountHistogram histogram_;
  Cells cells_;
  static constexpr std::size_t ahead = 16;          // events whose pixels are prefetched
  std::size_t capacity_ = 1024;                     // of the ring, a power of two
  std::vector<Waiting> ring_;                       // added and not yet dropped, followed by `ahead` unused ones
  std::size_t front_ = 0;                           // of the ring
  std::size_t given_ = 0;                           // in the ring
  std::size_t counted_ = 0;                         // of those in the ring, from the front
  std::array<std::uint32_t, large + 1> changes_{};  // pixels that went from each low count to the next, minus those that returned
  std::uint32_t any_changed_ = 0;                   // the low counts with changes, or'ed
  CameraTime tick_ = CameraTime::min();
  CameraTime last_ = CameraTime::min();  // of the added events
};

}  // namespace tactile::heatmaps
