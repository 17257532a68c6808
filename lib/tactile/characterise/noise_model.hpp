#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tactile::characterise {

/// The noise of ordinary pixels: each pixel fires by itself, at intervals of a gamma distribution, at a rate of its own.
///
/// - shape k of the intervals: 1 for a Poisson process; the variation of the intervals is 1 / sqrt(k)
/// - rates are log-normal between the pixels, with the standard deviation `spread` of ln(rate)
struct NoiseModel {
  double shape = 1;   ///< > 0
  double spread = 0;  ///< >= 0
};

/// Moments of the counts n1, n2 of one pixel in two successive windows, over all pixels.
struct WindowMoments {
  double differences = 0;  ///< mean of (n1 - n2)^2 / mean of (n1 + n2): 1 for a Poisson process
  double products = 0;     ///< mean of n1 n2 / (mean of n)^2 - 1: 0 if all pixels have the same rate
};

/// What the model says, for windows with `mean` events per pixel. A process of whole shape k is a Poisson process of k times the
/// rate of which every k-th event counts; other shapes lie between, on a line over 1 / k. @param mean  > 0
WindowMoments moments_of(const NoiseModel& model, double mean);

/// The share of the pixels without an event in any of several recordings, with these mean numbers of events per pixel. A pixel
/// has its rate in all of them, but recordings do not continue each other.
double silent_share(const NoiseModel& model, std::span<const double> means);

/// Counts of pixels in pairs of successive windows, as sums.
struct WindowSums {
  double pairs = 0, sum = 0, squared_differences = 0, products = 0;

  void add(std::uint32_t n1, std::uint32_t n2) {
    const double a = n1, b = n2;
    pairs += 1;
    sum += a + b;
    squared_differences += (a - b) * (a - b);
    products += a * b;
  }
  WindowSums& operator+=(const WindowSums& other);
};

/// The model with these moments; shape 1 and spread 0 without events. The shape is at most 12.
NoiseModel noise_model(const WindowSums& sums);

}  // namespace tactile::characterise
