#include "tactile/alignment/clock_fit.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/straight_line.hpp"

namespace tactile::alignment {
namespace {

/// An anchor as a point of a line: x is its clock minus the middle, y its offset minus that of the first anchor [us].
struct Point : UncertainPoint {  // sigma includes a drift that is not measured
  double weight = 1;
  bool used = true;

  double off(const StraightLine& line) const { return std::abs(y - line.at(x)); }
};

StraightLine first_line(const std::vector<Point>& points, bool with_gradient) {
  StraightLine line;
  if (with_gradient) line.gradient = theil_sen_gradient(std::vector<UncertainPoint>(points.begin(), points.end()));
  std::vector<Weighted> offsets;
  offsets.reserve(points.size());
  for (const Point& p : points) offsets.push_back({p.y - line.gradient * p.x, 1.0 / (p.sigma * p.sigma)});
  line.mean_y = weighted_median(std::move(offsets));
  return line;
}

/// The scatter of the anchors in their own standard deviations; at least 1, and 1 where they are too few.
double scatter_of(const std::vector<Point>& points, const StraightLine& line, std::size_t free_parameters) {
  std::vector<double> sizes;
  for (const Point& p : points) {
    if (p.used) sizes.push_back(p.off(line) / p.sigma);
  }
  if (sizes.size() <= free_parameters) return 1.0;
  const auto n = static_cast<double>(sizes.size());
  // The lower median: of two anchors the one that fits.
  return std::max(1.0, sigma_per_median * lower_median(sizes) * std::sqrt(n / (n - static_cast<double>(free_parameters))));
}

/// The line through the used points. @param with_gradient  else it is level
StraightLine least_squares(const std::vector<Point>& points, bool with_gradient) {
  std::vector<WeightedPoint> used;
  for (const Point& p : points) {
    if (p.used) used.push_back({p.x, p.y, p.weight});
  }
  StraightLine line = line_through(used);
  if (!with_gradient) line.gradient = 0;
  return line;
}

/// Huber's line from `line` on. Marks the anchors that are too far from it as not used.
StraightLine robust_line(std::vector<Point>& points, StraightLine line, bool with_gradient, double reject_beyond) {
  const std::size_t free_parameters = with_gradient ? 2 : 1;
  for (int round = 0; round < 30; ++round) {
    const double scatter = scatter_of(points, line, free_parameters);
    for (Point& p : points) {
      const double size = p.off(line) / (p.sigma * scatter);
      p.used = size <= reject_beyond;
      p.weight = huber_weight(size) / (p.sigma * p.sigma);
    }
    const StraightLine next = least_squares(points, with_gradient);
    const double xx_about_0 = next.weighted_xx + next.weights * next.mean_x * next.mean_x;
    if (!(next.weights > 0) || (with_gradient && !(next.weighted_xx > 1e-12 * xx_about_0))) {
      for (Point& p : points) p.used = true;
      return line;
    }
    const bool settled = std::abs(next.at(0) - line.at(0)) < 1e-3 && std::abs(next.gradient - line.gradient) < 1e-12;
    line = next;
    if (settled) break;
  }
  return line;
}

/// Fits one clock step by step.
class Fitter {
 public:
  Fitter(std::span<const ClockAnchor> anchors, std::int64_t reference_us, const ClockFitOptions& options)
      : anchors_(anchors),
        reference_us_(reference_us),
        middle_us_(options.middle_us.value_or(reference_us)),
        options_(options),
        usual_drift_(1e-6 * options.usual_drift_ppm) {}

  /// @return why there is no clock; empty if there is one
  std::string fit(ClockFit& fit) {
    if (anchors_.empty()) return "nothing relates the two clocks";
    if (__builtin_sub_overflow(us_of(anchors_.front().camera), anchors_.front().clock_us, &base_us_)) return too_far_apart;
    set_points();
    why_no_drift_ = reason_against_drift();
    with_drift_ = why_no_drift_.empty();
    if (with_drift_) {
      if (std::string refused = fit_drift(); !refused.empty()) return refused;
    }
    if (!with_drift_) fit_offset();
    for (std::size_t i = 0; i < points_.size(); ++i) fit.used[i] = points_[i].used;
    if (std::string refused = contradiction(); !refused.empty()) return refused;
    return set_clock(fit);
  }

 private:
  static constexpr const char* too_far_apart = "the two clocks lie further apart than 64 bits of microseconds";

  void set_points() {
    for (const ClockAnchor& anchor : anchors_) {
      const std::int64_t in_camera = between(anchors_.front().camera, anchor.camera).count();
      const std::int64_t in_clock = saturating_subtract(anchor.clock_us, anchors_.front().clock_us);
      points_.push_back({{.x = static_cast<double>(saturating_subtract(anchor.clock_us, middle_us_)),
                          .y = static_cast<double>(saturating_subtract(in_camera, in_clock)),
                          .sigma = std::max(1.0, std::hypot(anchor.sigma_us, anchor.bias_us))}});
    }
  }

  /// A point counts for the drift unless it is far more uncertain than the best, and than a usual drift over all the points'
  /// time.
  std::string reason_against_drift() const {
    const auto best =
        std::min_element(points_.begin(), points_.end(), [](const Point& a, const Point& b) { return a.sigma < b.sigma; });
    const auto by_x = [](const Point& a, const Point& b) { return a.x < b.x; };
    const auto [earliest, latest] = std::minmax_element(points_.begin(), points_.end(), by_x);
    const double most_sigma = std::max(10.0 * best->sigma, 0.5 * usual_drift_ * (latest->x - earliest->x));
    std::vector<Point> exact;
    std::copy_if(points_.begin(), points_.end(), std::back_inserter(exact),
                 [&](const Point& p) { return p.sigma <= most_sigma; });
    if (exact.size() < options_.drift_needs_anchors)
      return fmt::format("{} of {} anchors", exact.size(), options_.drift_needs_anchors);
    const auto [first, last] = std::minmax_element(exact.begin(), exact.end(), by_x);
    const double span_us = last->x - first->x, least_span_us = static_cast<double>(options_.drift_needs_span.count());
    if (span_us >= least_span_us) return {};
    return fmt::format("the anchors span {:.0f} of {:.0f} s", 1e-6 * span_us, 1e-6 * least_span_us);
  }

  /// @return why the drift is refused; empty if it is not. The anchors may not determine the drift
  std::string fit_drift() {
    line_ = robust_line(points_, first_line(points_, true), true, options_.reject_beyond);
    scatter_ = scatter_of(points_, line_, 2);
    const double gradient_sigma = scatter_ / std::sqrt(least_squares(points_, true).weighted_xx);
    const auto left = std::count_if(points_.begin(), points_.end(), [](const Point& p) { return p.used; });
    if (!(gradient_sigma < usual_drift_) || static_cast<std::size_t>(left) < options_.drift_needs_anchors) {
      with_drift_ = false;
      why_no_drift_ = "the anchors do not determine it";
    } else if (std::abs(line_.gradient) > 1e-6 * options_.most_drift_ppm) {
      return fmt::format("the anchors give a drift of {:.0f} ± {:.0f} ppm; expected at most {:.0f}", 1e6 * line_.gradient,
                         normal_95 * 1e6 * gradient_sigma, options_.most_drift_ppm);
    }
    return {};
  }

  void fit_offset() {
    for (Point& p : points_) {
      p.used = true;
      p.sigma = std::hypot(p.sigma, usual_drift_ * p.x);
    }
    line_ = robust_line(points_, first_line(points_, false), false, options_.reject_beyond);
    scatter_ = scatter_of(points_, line_, 1);
  }

  /// Why the anchors contradict each other; empty if they do not.
  std::string contradiction() const {
    constexpr double least_share = 0.6, most_scatter = 30.0;
    double weight = 0, all_weight = 0;
    for (const Point& p : points_) {
      const double own = 1.0 / (p.sigma * p.sigma);
      all_weight += own;
      weight += p.used ? own : 0.0;
    }
    if (weight > least_share * all_weight && scatter_ <= most_scatter) return {};
    return fmt::format(
        "the {} anchors contradict each other: most of the weight must lie within {:.0f} standard deviations of a line, and "
        "they may scatter by {:.0f} times their own",
        anchors_.size(), options_.reject_beyond, most_scatter);
  }

  /// @return why there is no clock; empty if there is one
  std::string set_clock(ClockFit& fit) const {
    // Each anchor's share in the value at the middle.
    const StraightLine line = least_squares(points_, with_drift_);
    double variance = 0, drift_share = 0, own_sigma = 0, bias = 0;
    std::vector<double> sizes;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Point& p = points_[i];
      if (!p.used) continue;
      const double by_drift = with_drift_ ? line.mean_x * (p.x - line.mean_x) / line.weighted_xx : 0;
      const double share = p.weight * (1 / line.weights - by_drift);
      variance += share * share * anchors_[i].sigma_us * anchors_[i].sigma_us;
      drift_share += share * p.x;
      bias += share * anchors_[i].bias_us;
      own_sigma = sizes.empty() ? p.sigma : std::min(own_sigma, p.sigma);
      sizes.push_back(p.off(line_));
    }
    variance *= scatter_ * scatter_;
    if (!with_drift_) variance += usual_drift_ * usual_drift_ * drift_share * drift_share;
    variance += bias * bias;

    const double at_reference = line_.at(static_cast<double>(saturating_subtract(reference_us_, middle_us_)));
    constexpr double furthest_us = 9e18;  // of int64's 9.22e18
    if (!(std::abs(at_reference) < furthest_us)) return too_far_apart;
    const std::int64_t offset_us = saturating_add(base_us_, std::llround(at_reference));
    const std::int64_t half_us = std::max<std::int64_t>(1, std::llround(normal_95 * std::sqrt(variance)));
    FittedClock& clock = fit.clock.emplace();
    clock.relation = {.offset_us = offset_us, .drift_ppm = 1e6 * line_.gradient, .reference_us = reference_us_};
    clock.residual_us = sizes.size() < 3 ? own_sigma : sigma_per_median * median(sizes);
    clock.offset_low_us = saturating_subtract(offset_us, half_us);
    clock.offset_high_us = saturating_add(offset_us, half_us);
    clock.anchors = static_cast<int>(sizes.size());
    clock.method = fmt::format("motions ({})", sizes.size());
    if (!with_drift_) clock.method += fmt::format("; drift not estimated: {}", why_no_drift_);
    return {};
  }

  std::span<const ClockAnchor> anchors_;
  std::int64_t reference_us_, middle_us_;
  const ClockFitOptions& options_;
  double usual_drift_;
  std::int64_t base_us_ = 0;  ///< the first anchor's offset
  std::vector<Point> points_;
  bool with_drift_ = false;
  std::string why_no_drift_;
  StraightLine line_;
  double scatter_ = 1;
};

}  // namespace

ClockFit fit_clock(std::span<const ClockAnchor> anchors, std::int64_t reference_us, const ClockFitOptions& options) {
  ClockFit fit{.clock = {}, .refused = {}, .used = std::vector<bool>(anchors.size(), true)};
  fit.refused = Fitter(anchors, reference_us, options).fit(fit);
  return fit;
}

}  // namespace tactile::alignment
