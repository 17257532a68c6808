#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tactile/core/measured.hpp"
#include "tactile/core/time.hpp"

namespace tactile::characterise {

/// A frequency at which the event rate varies.
struct FlickerLine {
  Measured hz;
  Measured depth;              ///< d of the rate r (1 + d sin(2 pi hz t)): of events, not of light
  double chance = 0;           ///< probability that noise alone gives one line as strong anywhere in what was searched
  std::size_t lit_pixels = 0;  ///< unusual pixels that fire in step
  bool is_local = false;       ///< only they show it, and r is their rate
};

/// The chance that the mean of `n` exponential values is `ratio` times their expectation or more.
/// Source: E. B. Wilson and M. M. Hilferty, The distribution of chi-square, PNAS 17 (1931).
double chance_of(double ratio, double n);

struct Flicker {
  double from_hz = 0, to_hz = 0;   ///< what was searched: up to half the rate of the read-outs; nothing if to_hz <= from_hz
  std::vector<FlickerLine> lines;  ///< by frequency
  double resolution_hz = 0;
  std::vector<double> spectrum;  ///< power over that of the neighbouring frequencies, i * resolution_hz
};

/// A line, and how many others are its multiples: pulsed light has a line at each multiple of its frequency. If that frequency
/// is below the searched range, `line` is the lowest of its multiples, with the frequency of the pulses: the greatest of which
/// the lines are multiples within their uncertainty, and of which most multiples up to the last line have one.
struct FlickerSeries {
  FlickerLine line;
  std::size_t multiples = 0;
};
std::vector<FlickerSeries> series_of(const Flicker& flicker);

/// The spectrum of an event rate, by averaged periodograms (Hann windows that overlap by half).
///
/// A line is a frequency whose mean power over that of the frequencies around it has a chance below 1 in 1000 for noise, for all
/// frequencies together. Multiples of the read-out frequency are left out, and what they look like in bins.
/// Source: P. D. Welch, The use of fast Fourier transform for the estimation of power spectra, IEEE Trans. Audio Electroacoust.
/// 15 (1967).
class FlickerMeter {
 public:
  /// @param bin_us      length of a bin: the period of a steady read-out of at most 1 ms, else 125 us
  /// @param readout_us  period of the read-outs, 0 if there is none
  /// @param duration    of the shortest recording; segments are about 1 s, and at least eight if possible
  FlickerMeter(double bin_us, double readout_us, microseconds duration);

  void begin_recording();
  /// One event in bin `index` of the recording, >= 0. Bins before the last one that was begun count in it.
  void add(std::int64_t index) {
    if (index >= begin_ + length_) advance(index);
    counts_[static_cast<std::size_t>(std::max<std::int64_t>(0, index - begin_))] += 1;
  }
  Flicker flicker() const;

 private:
  void advance(std::int64_t index);
  void take_segment();
  FlickerLine line_at(std::size_t i, double floor, double chance) const;
  bool belongs_to_readouts(double hz) const;

  double bin_us_, readout_us_;
  std::int64_t length_, begin_ = 0;
  std::vector<float> counts_;
  std::vector<double> power_, squares_;  ///< sums over segments
  double segments_ = 0, events_ = 0;
};

}  // namespace tactile::characterise
