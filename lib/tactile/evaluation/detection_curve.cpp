#include "tactile/evaluation/detection_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "tactile/core/duration_units.hpp"

namespace tactile::evaluation {

DetectionTimes::DetectionTimes(std::span<const results::RunDetections> runs, Touch touch) : runs_(runs.size()) {
  for (std::size_t run = 0; run < runs.size(); ++run) {
    for (const results::Detection& detection : runs[run].detections) {
      if (detection.interval.touch != touch) continue;
      const bool is_missed = detection.outcome == results::DetectionOutcome::missed;
      double ms = is_missed ? in_ms(detection.limit) : in_ms(detection.delay);
      if (detection.ahead) ms = std::min(ms, 0.0);
      times_.push_back({ms, is_missed, run});
    }
  }
  std::sort(times_.begin(), times_.end(), [](const Time& a, const Time& b) {
    return std::tie(a.ms, a.is_censored, a.run) < std::tie(b.ms, b.is_censored, b.run);
  });
}

std::vector<double> DetectionTimes::weights_of(const RunsByObject& chosen) const {
  std::vector<double> weights(runs_);
  for (const auto& object : chosen) {
    for (const std::size_t run : object) ++weights[run];
  }
  return weights;
}

double DetectionTimes::weight_of_all(std::span<const double> weights) const {
  double sum = 0;
  for (const Time& time : times_) sum += weights[time.run];
  return sum;
}

std::optional<double> DetectionTimes::share_within(const RunsByObject& chosen, double ms) const {
  const std::vector<double> weights = weights_of(chosen);
  double at_risk = weight_of_all(weights), not_detected = 1;
  if (at_risk == 0) return std::nullopt;
  for (const Time& time : times_) {
    if (time.ms > ms || at_risk <= 0) break;
    if (!time.is_censored) not_detected *= 1 - weights[time.run] / at_risk;
    at_risk -= weights[time.run];
  }
  return 1 - not_detected;
}

std::optional<DetectionTimes::Quantile> DetectionTimes::quantile(const RunsByObject& chosen, double q) const {
  const std::vector<double> weights = weights_of(chosen);
  const double all = weight_of_all(weights);
  if (all == 0) return std::nullopt;
  // As `nearest_rank_quantile`; weights are whole numbers.
  const double needed = std::max(1.0, std::ceil(q * all));
  double so_far = 0, detected = 0;
  Quantile found;
  for (const Time& time : times_) {
    if (so_far >= needed && time.ms > found.ms) break;
    if (weights[time.run] == 0) continue;
    so_far += weights[time.run];
    detected += time.is_censored ? 0 : weights[time.run];
    if (so_far - weights[time.run] < needed) found.ms = time.ms;
  }
  found.is_lower_bound = detected < needed;
  return found;
}

double DetectionTimes::one_interval(std::size_t results) const {
  return times_.empty() ? 0 : static_cast<double>(results) / static_cast<double>(times_.size());
}

std::optional<double> DetectionTimes::missed_share(const RunsByObject& chosen) const {
  const std::vector<double> weights = weights_of(chosen);
  const double all = weight_of_all(weights);
  if (all == 0) return std::nullopt;
  double missed = 0;
  for (const Time& time : times_) missed += time.is_censored ? weights[time.run] : 0;
  return missed / all;
}

std::span<const double> curve_times_ms() {
  static constexpr std::array<double, 25> times{0,  2,  4,  6,  8,  10,  12,  14,  16,  18,  20,  25, 30,
                                                35, 40, 50, 60, 80, 100, 150, 200, 250, 300, 400, 500};
  return times;
}

std::vector<results::DetectedWithin> detection_curve(const DetectionTimes& times, const CrossedResults& chosen,
                                                     const results::BootstrapOptions& options) {
  std::vector<results::DetectedWithin> curve;
  if (chosen.empty()) return curve;
  const Range range{0, 1, times.one_interval(result_count(chosen))};
  for (const double ms : curve_times_ms()) {
    const auto share = [&times, ms](const RunsByObject& drawn) { return times.share_within(drawn, ms); };
    curve.push_back({ms, figure_over_objects(chosen, share, options, range)});
  }
  // The share never falls, so a lower bound holds for all later times, and an upper one for all earlier ones.
  for (std::size_t i = 1; i < curve.size(); ++i) {
    results::Figure &at = curve[i].share, &earlier = curve[i - 1].share;
    if (at.low && earlier.low) at.low = std::max(*at.low, *earlier.low);
  }
  for (std::size_t i = curve.size(); i-- > 1;) {
    results::Figure &at = curve[i - 1].share, &later = curve[i].share;
    if (at.high && later.high) at.high = std::min(*at.high, *later.high);
  }
  return curve;
}

}  // namespace tactile::evaluation
