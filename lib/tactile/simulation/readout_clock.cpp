#include "tactile/simulation/readout_clock.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"

namespace tactile::simulation {
namespace {

constexpr double decayed = 2.1462;  // (1 + x) exp(-x) is 1 / e

/// The noise that gives two low-passes in a row, w = (1 - kept B)^-2 noise, this standard deviation.
double noise_of(double deviation, double kept) {
  const double kept_squared = kept * kept;
  return deviation * std::sqrt(std::pow(1 - kept_squared, 3) / (1 + kept_squared));
}

}  // namespace

ReadoutClock::ReadoutClock(const EventCameraOptions& options, std::uint64_t seed)
    : readout_us_(options.readout_us),
      us_per_event_(options.readout_events_per_s > 0 ? 1e6 / options.readout_events_per_s : 0),
      scan_us_(options.scan_us_per_column),
      wander_us_(options.wander_us),
      wander_kept_(std::exp(-decayed * 1e-6 * options.readout_us / options.wander_s)),
      wander_noise_us_(noise_of(options.wander_us, wander_kept_)),
      jitter_us_(options.jitter_us),
      by_rows_(options.scan_us_per_row != 0),
      random_(seed) {
  if (by_rows_ && scan_us_ != 0)
    throw Error("simulated camera: scan_us_per_column and scan_us_per_row are both set; expected one of them to be 0");
  if (by_rows_) scan_us_ = options.scan_us_per_row;
  const int lines = by_rows_ ? options.size.height : options.size.width;
  last_ = lines - 1;
  scan_us_ = std::clamp(scan_us_, -readout_us_ / lines, readout_us_ / lines);
}

void ReadoutClock::advance(std::size_t events) {
  const double scanned_us = next_us_ + std::abs(scan_us_) * last_;
  ++readout_;
  delay_us_ += std::max(0.0, static_cast<double>(events) * us_per_event_ - readout_us_);
  next_us_ = static_cast<double>(readout_) * readout_us_ + delay_us_;
  if (wander_us_ > 0) {
    wander_driven_us_ = wander_kept_ * wander_driven_us_ + wander_noise_us_ * random_.normal();
    wander_now_us_ = wander_kept_ * wander_now_us_ + wander_driven_us_;
    next_us_ += wander_now_us_;
  }
  if (jitter_us_ > 0) next_us_ += std::clamp(jitter_us_ * random_.normal(), -0.25 * readout_us_, 0.25 * readout_us_);
  next_us_ = std::max(next_us_, scanned_us);
}

}  // namespace tactile::simulation
