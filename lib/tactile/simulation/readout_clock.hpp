#pragma once

#include <cstdint>
#include <optional>

#include "tactile/core/random.hpp"
#include "tactile/simulation/event_camera_options.hpp"

namespace tactile::simulation {

/// When the camera is read out, and the stamps of a read-out's events. Times are in us since the first read-out.
///
/// A read-out holds the light of all pixels at its start. Read-out k begins at
///
///   k readout_us + delay + wander + jitter
///
/// - A read-out of n events lasts at least n / readout_events_per_s. What it lasts longer than readout_us adds to the delay of
/// all
///   later ones.
/// - The wander is smooth, as that of real cameras: white noise through two equal low-passes of first order. Its standard
///   deviation is wander_us. Its autocorrelation, (1 + x) exp(-x) with x in proportion to the time, is 1 / e after wander_s.
/// - The jitter of each read-out is normal with the standard deviation jitter_us, limited to a quarter of readout_us.
///
/// Columns are stamped one after another. With scan_us_per_column > 0 the last column has the time of the start, and each lower x
/// is that much later; below 0 the first column is the earliest. scan_us_per_row does the same for rows. A scan lasts at most
/// readout_us, and a read-out begins after the scan of the one before. Stamps are whole us, rounded down.
class ReadoutClock {
 public:
  /// @throws Error  if both scans are set
  ReadoutClock(const EventCameraOptions& options, std::uint64_t seed);

  double next_us() const { return next_us_; }  ///< the start of the next read-out
  /// Moves to the next read-out. @param events  of the read-out that ends
  void advance(std::size_t events);

  bool scans() const { return scan_us_ != 0; }
  bool scans_rows() const { return by_rows_; }
  bool falls() const { return scan_us_ > 0; }  ///< the highest x or y is the earliest
  /// From the start of a read-out to the stamp of this pixel, which is not rounded yet.
  double offset_us(int x, int y) const {
    const int place = by_rows_ ? y : x;
    return scan_us_ > 0 ? scan_us_ * (last_ - place) : -scan_us_ * place;
  }

 private:
  double readout_us_, us_per_event_, scan_us_, wander_us_, wander_kept_, wander_noise_us_, jitter_us_;
  bool by_rows_ = false;
  int last_ = 0;  ///< the last column or row
  Random random_;
  std::int64_t readout_ = 0;
  double delay_us_ = 0, wander_driven_us_ = 0, wander_now_us_ = 0, next_us_ = 0;
};

}  // namespace tactile::simulation
