#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tactile/events/event.hpp"

namespace tactile::characterise {

/// A time in which nothing moves, [begin, end).
struct QuietStretch {
  CameraTime begin{}, end{};
};

/// Finds the times of a recording in which nothing moves.
///
/// Events are counted in 16 parts of the image and bins of 20 ms. The 0.2 s with the fewest events show the mean m of each
/// part and the dispersion D, the variance per mean, of all. Something moves in a bin with a part that has
///
///   n > m + 6 sqrt(D m + (0.05 m)^2 + 1)      0.05: how far a quiet rate wanders
///
/// Then m and D are measured again, in all quiet bins, until the bins stay the same. `NeighbourSteps` decides whether something
/// moves in the 0.2 s. Memory: 3.6 kB for a second with events.
class QuietMeter {
 public:
  static constexpr microseconds shortest{500'000};   ///< of a stretch
  static constexpr microseconds reference{200'000};  ///< the 0.2 s
  static constexpr microseconds margin{100'000};     ///< before and after a motion, which begins and ends slowly

  explicit QuietMeter(events::SensorSize size) : size_(size) {}

  /// Events in the order of the file.
  void add(std::span<const events::Event> events);
  bool is_empty() const { return bins_.empty(); }
  double seconds() const { return std::chrono::duration<double>(between(first_, last_)).count(); }
  /// The 0.2 s with the fewest events. @pre  there is an event
  QuietStretch quietest() const;
  /// In order of time; the whole recording if nothing moves; nothing if it is shorter than a stretch.
  std::vector<QuietStretch> stretches() const;

 private:
  static constexpr std::int64_t bin_us = 20'000, reference_bins = reference.count() / bin_us;
  static constexpr int side = 4;
  using Counts = std::array<std::uint32_t, static_cast<std::size_t>(side* side)>;
  struct Bin {
    std::int64_t index = 0;  ///< bins without events are not kept
    Counts counts{};
  };

  /// The bins of the 0.2 s, [first, second) by place in `bins_`.
  std::pair<std::size_t, std::size_t> quietest_bins() const;
  /// The bins that move, by place in `bins_`.
  std::vector<bool> moving() const;

  events::SensorSize size_;
  std::vector<Bin> bins_;
  CameraTime begin_{}, first_{}, last_{};  ///< first_, last_: earliest and latest
};

}  // namespace tactile::characterise
