#pragma once

#include <bitset>
#include <cstddef>
#include <span>
#include <vector>

#include "tactile/characterise/quiet_stretches.hpp"
#include "tactile/events/event.hpp"

namespace tactile::characterise {

/// Decides whether something moves in 0.2 s. A moving edge makes neighbouring pixels fire together. Noise makes each fire alone.
///
/// With n_a, n_b in {0, 1} whether two neighbours fire in steps of 2 ms, it is the correlation of each with the other `lag` steps
/// later, pooled over all pairs across and down,
///
///   r(lag) = sum of cov(n_a(k), n_b(k + lag)) / (2 sum of var(n_a))
///
/// r(0) of noise is 0.001 or less (a still DVXplorer), of a scene in which something moves 0.006 or more (three real recordings),
/// and of a simulated press or slip 0.04 or more. Light that flickers raises it too, but it does so again a period later; a
/// motion is elsewhere by then. Memory: 16 bytes for a pixel.
class NeighbourSteps {
 public:
  NeighbourSteps(events::SensorSize size, CameraTime begin)
      : begin_(begin), width_(static_cast<std::size_t>(size.width)), fired_(width_ * static_cast<std::size_t>(size.height)) {}

  /// @param events  in any order, inside the sensor; those outside the 0.2 s do not count
  void add(std::span<const events::Event> events);
  double correlation(std::size_t lag) const;
  /// r(0) is above 0.003 by more than 4 of its standard errors, and no r of 50 to 100 ms is half as large: these lags contain
  /// a period, or a multiple of it, of all light that flickers 20 times a second or more.
  bool is_motion() const;

 private:
  static constexpr std::size_t steps = 100;
  using Fired = std::bitset<steps>;
  template <class Use>
  void for_pairs(const Use& use) const;

  CameraTime begin_;
  std::size_t width_;
  std::vector<Fired> fired_;  ///< by pixel
};

}  // namespace tactile::characterise
