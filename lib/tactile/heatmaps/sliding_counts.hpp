#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/heatmaps/cell_counts.hpp"
#include "tactile/heatmaps/count_histogram.hpp"

namespace tactile {

/// Events per pixel over a history that slides along a recording:
///
///   E(x, y) = number of events with t_c - t_h <= t < t_c at the pixel, either polarity
///
/// and how many pixels of the whole and of each cell of a grid have each count. Adding and removing cost as much as there are
/// events, never as much as there are pixels. Memory is asked for only when more events are held, or at one pixel, than ever
/// before.
class SlidingCounts {
 public:
  /// @param history  t_h > 0
  /// @param grid     of the same sensor; by default no pixel belongs to a cell
  /// @throws Error  if the sensor has no area, more than 2^26 pixels or more than 2^15 each way, or the history is not positive
  SlidingCounts(SensorSize size, microseconds history, const CellGrid& grid = {});

  /// Appends events not yet counted, ascending in time and none before those already given.
  /// @throws Error  if they go back in time or lie outside the sensor; none of them is taken then
  void add(std::span<const Event> events);

  /// Moves the window to [t_c - t_h, t_c): counts the events given up to there, forgets those before it; later events wait.
  /// @throws Error  if `tick` lies before the one last moved to
  void move_to(CameraTime tick);

  SensorSize size() const { return size_; }
  std::uint64_t events() const { return counted_; }  ///< counted now

  /// E(x, y)
  std::uint32_t at(int x, int y) const {
    const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(x);
    return small_counts_[pixel] < large ? small_counts_[pixel] : large_counts_[pixel];
  }

  static constexpr std::uint16_t large = CellCounts<std::uint8_t>::count_limit - 1;
  std::span<const std::uint16_t> small_counts() const { return small_counts_; }  ///< [height, width] min(E, large)
  const CountHistogram& histogram() const { return histogram_; }                 ///< how many pixels have each E

  // The numbers of a cell's pixels fit one byte up to 15 x 15 of them.
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
  void tell_histogram();
  [[gnu::noinline]] void change_high_count(std::uint32_t pixel, int by);

  SensorSize size_;
  microseconds history_;
  std::vector<std::uint16_t> small_counts_;  // small, so that what is in use stays in the cache
  std::vector<std::uint32_t> large_counts_;  // of the pixels whose small count is `large`
  CountHistogram histogram_;
  Cells cells_;
  static constexpr std::size_t ahead = 16;          // events, whose pixels are asked of the memory before they are counted
  std::size_t capacity_ = 1024;                     // of the ring, a power of two
  std::vector<Waiting> ring_;                       // given and not yet forgotten; and `ahead` that are of no meaning
  std::size_t front_ = 0;                           // of the ring
  std::size_t given_ = 0;                           // in the ring
  std::size_t counted_ = 0;                         // of those, from the front
  std::array<std::uint32_t, large + 1> changes_{};  // of pixels from each low count to the next, less those that came back
  std::uint32_t any_changed_ = 0;                   // the low counts with changes, or'ed
  CameraTime tick_ = CameraTime::min();
  CameraTime last_ = CameraTime::min();  // of the events given
};

}  // namespace tactile
