#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "tactile/events/event.hpp"
#include "tactile/features/sliding_sums.hpp"

namespace tactile::features {

inline constexpr std::size_t features_of_window = 21, windows_of_tick = 4, feature_count = features_of_window * windows_of_tick;

/// The numbers that a model without heatmaps reads at a tick: 21 of each quarter of the history, the oldest quarter first.
using TickFeatures = std::array<float, feature_count>;

/// Of one window, with n events, m of them brighter, x and y in widths and heights of the sensor, from 0 to 1:
///
///    0      ln(1 + n)                                  >= 0
///    1      (m + 1/2) / (n + 1)                        in (0, 1)
///    2, 3   mean of x, of y                            in [0, 1]; 1/2 without events
///    4, 5   standard deviation of x, of y              in [0, 1/2]
///    6      covariance of x and y                      in [-1/4, 1/4]
///    7, 8   mean x, mean y of brighter - of darker     in [-1, 1]; 0 without events of both: motion separates the two
///    9      mean of x^2 + y^2 of brighter - of darker  in [-2, 2]; the same
///   10      n^2 / sum of c^2 / 432                     in [0, 1]: the share of lit cells, if all of them are equal
///   11      ln(1 + sum of (brighter - darker)^2 / n)   >= 0: noise of both polarities gives about ln 2
///   12-20   share of events in each of 3 x 3 fields    row by row; 1/9 without events
///
/// c is the number of events in a cell. Every number is finite for every input. Computed in double from whole sums, then rounded.
void window_features(const EventSums& sums, events::SensorSize sensor, std::span<float, features_of_window> features);

/// The bins for a tick and a history: the longest that both a tick and a quarter of the history are whole numbers of. Nothing if
/// the history is no multiple of 4 us, or has more than `SlidingSums::most_bins` such bins.
/// @throws Error  if one of them is not above 0
std::optional<microseconds> feature_bin(microseconds tick, microseconds history);

/// The same. @throws Error  also if there are no such bins
microseconds bin_of(microseconds tick, microseconds history);

/// The features of the history that `sums` covers, in bins of `feature_bin`. They depend only on its events, not on the bins.
TickFeatures tick_features(const SlidingSums& sums, events::SensorSize sensor);

}  // namespace tactile::features
