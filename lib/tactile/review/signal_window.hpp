#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tactile::review {

/// A part of a signal, thinned to what a picture shows: of each bucket of time its least, mean and largest value. NaN is a gap.
struct SignalWindow {
  std::int64_t bucket_us = 0;      ///< 0: the samples themselves
  std::int64_t over_us = 0;        ///< of a rate: each value is the mean over so much time; else 0
  std::vector<std::int64_t> t_us;  ///< the middle of each bucket, or the sample's time
  std::vector<double> least, mean, most;

  void add(std::int64_t t, double low, double middle, double high);
};

/// {"bucket_us", "over_us", "t_us", "min", "mean", "max"}; NaN is null.
nlohmann::json json_of(const SignalWindow& window);

/// The asked part of time, [from, to), in microseconds after the first event, and how many buckets it may have.
struct WindowRequest {
  std::int64_t from_us = 0, to_us = 0;  ///< from < to
  std::int64_t points = 1200;           ///< > 0
  std::int64_t smooth_us = 0;           ///< rates are means over so much time, >= 0

  /// The shortest whole number of `unit_us` of which at most `points` cover the part.
  std::int64_t bucket_us(std::int64_t unit_us) const;
};

/// A signal of samples.
struct SampledSignal {
  std::string name, unit, label;
  std::vector<std::int64_t> t_us;  ///< ascending
  std::vector<float> values;       ///< one for each time; NaN is a gap
};

/// With as many samples as points or fewer, the samples themselves, and the nearest one on either side, so that a line reaches
/// both edges. Else buckets that begin at whole multiples of their length; empty ones are left out.
SignalWindow window_of(const SampledSignal& signal, const WindowRequest& request);

}  // namespace tactile::review
