#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/results/delay_table.hpp"
#include "tactile/results/detection.hpp"

namespace tactile::evaluation {

/// The times from onset to detection of all intervals of one class. A missed interval is censored: it was not detected until its
/// limit, min(end, start + window) - start. One that was predicted ahead of its onset is detected at 0.
class DetectionTimes {
 public:
  DetectionTimes(std::span<const results::RunDetections> runs, Touch touch);

  /// The share of intervals detected within a time, by Kaplan and Meier:
  ///
  ///   1 - product over t <= ms of (1 - detected at t / not yet detected and not yet censored just before t)
  ///
  /// At equal times, detections come before censored ones. After the last time the share stays as it is.
  /// @return  in [0, 1]; nothing without intervals
  /// Source: E. L. Kaplan and P. Meier, Nonparametric estimation from incomplete observations, JASA 53 (1958).
  std::optional<double> share_within(const RunsByObject& chosen, double ms) const;

  struct Quantile {
    double ms = 0;
    bool is_lower_bound = false;  ///< fewer than the share q of the intervals are detected within it
  };

  /// The least time that the share `q` of all intervals does not exceed; a missed one counts with its limit.
  std::optional<Quantile> quantile(const RunsByObject& chosen, double q) const;

  std::optional<double> missed_share(const RunsByObject& chosen) const;  ///< in [0, 1]

  /// The `Range::step` of a share of intervals: what one of them is in the mean of so many results.
  double one_interval(std::size_t results) const;

 private:
  struct Time {
    double ms = 0;
    bool is_censored = false;
    std::size_t run = 0;
  };

  /// How often each run was chosen.
  std::vector<double> weights_of(const RunsByObject& chosen) const;
  double weight_of_all(std::span<const double> weights) const;

  std::size_t runs_ = 0;
  std::vector<Time> times_;  ///< ascending; at equal times detections first
};

/// The times of `DelayTable::curve` [ms]: from 0 to 500, close together at first.
std::span<const double> curve_times_ms();

/// The curve over all of these runs. No bound falls with time, as no share does. @param chosen  those that have an interval of
/// the class
std::vector<results::DetectedWithin> detection_curve(const DetectionTimes& times, const CrossedResults& chosen,
                                                     const results::BootstrapOptions& options);

}  // namespace tactile::evaluation
