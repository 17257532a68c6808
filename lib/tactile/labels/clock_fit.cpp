#include "tactile/labels/clock_fit.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tactile/core/robust_statistics.hpp"

namespace tactile {
namespace {

constexpr double normal_95 = 1.96;
constexpr std::array<AnchorKind, 8> all_kinds{AnchorKind::stage_output, AnchorKind::sync_tap,    AnchorKind::imu,
                                              AnchorKind::ring_down,    AnchorKind::first_shear, AnchorKind::host_time,
                                              AnchorKind::film_of_arm,  AnchorKind::film_of_skin};

/// An anchor in numbers of ordinary size: microseconds from the middle, and offset less that of the first anchor.
struct Point : UncertainPoint {  // sigma: all of it, a drift that is not measured included
  double weight = 1;
  bool used = true;
};

struct Line {
  double at_middle = 0, slope = 0;

  double residual(const Point& p) const { return p.y - at_middle - slope * p.x; }
};

Line first_line(const std::vector<Point>& points, bool with_slope) {
  Line line;
  if (with_slope) line.slope = theil_sen_gradient(std::vector<UncertainPoint>(points.begin(), points.end()));
  std::vector<Weighted> offsets;
  for (const Point& p : points) offsets.push_back({p.y - line.slope * p.x, 1.0 / (p.sigma * p.sigma)});
  line.at_middle = weighted_median(std::move(offsets));
  return line;
}

/// How many times the anchors' own standard deviations they really scatter; 1 at least, and where they are too few to tell.
double scatter_of(const std::vector<Point>& points, const Line& line, std::size_t free_parameters) {
  std::vector<double> sizes;
  for (const Point& p : points) {
    if (p.used) sizes.push_back(std::abs(line.residual(p)) / p.sigma);
  }
  if (sizes.size() <= free_parameters) return 1.0;
  const auto n = static_cast<double>(sizes.size());
  // The lower median: of two anchors the one that fits.
  return std::max(1.0, sigma_per_median * lower_median(sizes) * std::sqrt(n / (n - static_cast<double>(free_parameters))));
}

struct Sums {
  double w = 0, wx = 0, wxx = 0, wy = 0, wxy = 0;

  double determinant() const { return w * wxx - wx * wx; }
};

Sums sums_of(const std::vector<Point>& points) {
  Sums s;
  for (const Point& p : points) {
    if (!p.used) continue;
    s.w += p.weight;
    s.wx += p.weight * p.x;
    s.wxx += p.weight * p.x * p.x;
    s.wy += p.weight * p.y;
    s.wxy += p.weight * p.x * p.y;
  }
  return s;
}

Line least_squares(const Sums& s, bool with_slope) {
  Line line;
  if (with_slope) line.slope = (s.w * s.wxy - s.wx * s.wy) / s.determinant();
  line.at_middle = (s.wy - line.slope * s.wx) / s.w;
  return line;
}

/// Huber's line from `line` on, and which anchors are beyond doubt not of it.
Line robust_line(std::vector<Point>& points, Line line, bool with_slope, double reject_beyond) {
  const std::size_t free_parameters = with_slope ? 2 : 1;
  for (int round = 0; round < 30; ++round) {
    const double scatter = scatter_of(points, line, free_parameters);
    for (Point& p : points) {
      const double size = std::abs(line.residual(p)) / (p.sigma * scatter);
      p.used = size <= reject_beyond;
      p.weight = huber_weight(size) / (p.sigma * p.sigma);
    }
    const Sums sums = sums_of(points);
    if (!(sums.w > 0) || (with_slope && !(sums.determinant() > 1e-12 * sums.w * sums.wxx))) {
      for (Point& p : points) p.used = true;
      return line;
    }
    const Line next = least_squares(sums, with_slope);
    const bool settled = std::abs(next.at_middle - line.at_middle) < 1e-3 && std::abs(next.slope - line.slope) < 1e-12;
    line = next;
    if (settled) break;
  }
  return line;
}

std::string kinds_text(std::span<const ClockAnchor> anchors, const std::vector<bool>& used) {
  std::string text;
  for (const AnchorKind kind : all_kinds) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < anchors.size(); ++i) count += used[i] && anchors[i].kind == kind ? 1 : 0;
    if (count > 0) text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", name_of(kind), count);
  }
  return text;
}

}  // namespace

std::string_view name_of(AnchorKind kind) {
  switch (kind) {
    case AnchorKind::stage_output:
      return "stage output";
    case AnchorKind::sync_tap:
      return "sync tap";
    case AnchorKind::imu:
      return "IMU";
    case AnchorKind::ring_down:
      return "ring-down";
    case AnchorKind::first_shear:
      return "first shear";
    case AnchorKind::host_time:
      return "host times";
    case AnchorKind::film_of_arm:
      return "film of the arm";
    case AnchorKind::film_of_skin:
      return "film against events";
  }
  return "";
}

ClockFit fit_clock(std::span<const ClockAnchor> anchors, std::int64_t reference_us, const ClockFitOptions& options) {
  ClockFit fit{.clock = {}, .refused = {}, .used = std::vector<bool>(anchors.size(), true)};
  const auto refuse = [&](std::string reason) {
    fit.refused = std::move(reason);
    return fit;
  };
  if (anchors.empty()) return refuse("nothing relates the two clocks");
  std::int64_t base_us = 0;
  if (__builtin_sub_overflow(us_of(anchors.front().camera), anchors.front().clock_us, &base_us))
    return refuse("the two clocks lie further apart than 64 bits of microseconds");

  const std::int64_t middle_us = options.middle_us.value_or(reference_us);
  std::vector<Point> points;
  for (const ClockAnchor& anchor : anchors) {
    const std::int64_t in_camera = between(anchors.front().camera, anchor.camera).count();
    const std::int64_t in_clock = saturating_subtract(anchor.clock_us, anchors.front().clock_us);
    points.push_back({{.x = static_cast<double>(saturating_subtract(anchor.clock_us, middle_us)),
                       .y = static_cast<double>(saturating_subtract(in_camera, in_clock)),
                       .sigma = std::max(1.0, std::hypot(anchor.sigma_us, anchor.bias_us))}});
  }
  // A witness that is far more uncertain than the best, and than what a usual drift does over all of the anchors' time, says
  // nothing of a drift.
  const auto best =
      std::min_element(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.sigma < b.sigma; });
  const auto [earliest, latest] =
      std::minmax_element(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.x < b.x; });
  const double usual = 1e-6 * options.usual_drift_ppm;
  const double telling_sigma = std::max(10.0 * best->sigma, 0.5 * usual * (latest->x - earliest->x));
  std::size_t telling = 0;
  double first_x = 0, last_x = 0;
  for (const Point& p : points) {
    if (p.sigma > telling_sigma) continue;
    first_x = telling == 0 ? p.x : std::min(first_x, p.x);
    last_x = telling == 0 ? p.x : std::max(last_x, p.x);
    ++telling;
  }
  const double span_us = last_x - first_x, least_span_us = static_cast<double>(options.drift_needs_span.count());
  bool with_slope = telling >= options.drift_needs_anchors && span_us >= least_span_us;
  std::string why_no_drift =
      telling < options.drift_needs_anchors
          ? fmt::format("{} {} it, {} are needed", telling, telling == 1 ? "anchor tells of" : "anchors tell of",
                        options.drift_needs_anchors)
          : fmt::format("its anchors span {:.0f} s, {:.0f} s are needed", 1e-6 * span_us, 1e-6 * least_span_us);
  Line line;
  double scatter = 1;
  if (with_slope) {
    line = robust_line(points, first_line(points, true), true, options.reject_beyond);
    scatter = scatter_of(points, line, 2);
    const Sums sums = sums_of(points);
    const double slope_sigma = scatter * std::sqrt(sums.w / sums.determinant());
    const auto left = std::count_if(points.begin(), points.end(), [](const Point& p) { return p.used; });
    if (!(slope_sigma < usual) || static_cast<std::size_t>(left) < options.drift_needs_anchors) {
      with_slope = false;
      why_no_drift = "the anchors leave it open";
    } else if (std::abs(line.slope) > 1e-6 * options.most_drift_ppm) {
      return refuse(fmt::format("the anchors ask for a drift of {:.0f} ± {:.0f} ppm; expected at most {:.0f}", 1e6 * line.slope,
                                normal_95 * 1e6 * slope_sigma, options.most_drift_ppm));
    }
  }
  if (!with_slope) {
    for (Point& p : points) {
      p.used = true;
      p.sigma = std::hypot(p.sigma, usual * p.x);
    }
    line = robust_line(points, first_line(points, false), false, options.reject_beyond);
    scatter = scatter_of(points, line, 1);
  }
  double weight = 0, all_weight = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    fit.used[i] = points[i].used;
    const double own = 1.0 / (points[i].sigma * points[i].sigma);
    all_weight += own;
    weight += points[i].used ? own : 0.0;
  }
  constexpr double least_share = 0.6, most_scatter = 30.0;
  if (!(weight > least_share * all_weight) || scatter > most_scatter) {
    return refuse(fmt::format(
        "the {} anchors contradict each other: most of the weight must lie within {:.0f} standard deviations of a line, and "
        "they may scatter by {:.0f} times their own",
        anchors.size(), options.reject_beyond, most_scatter));
  }

  // Each anchor's share in the value at the middle.
  const Sums sums = sums_of(points);
  double variance = 0, drift_share = 0;
  std::array<double, all_kinds.size()> bias{};
  std::vector<double> sizes;
  double own_sigma = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    if (!p.used) continue;
    const double share = with_slope ? p.weight * (sums.wxx - sums.wx * p.x) / sums.determinant() : p.weight / sums.w;
    variance += share * share * anchors[i].sigma_us * anchors[i].sigma_us;
    drift_share += share * p.x;
    bias[static_cast<std::size_t>(anchors[i].kind)] += share * anchors[i].bias_us;
    own_sigma = sizes.empty() ? p.sigma : std::min(own_sigma, p.sigma);
    sizes.push_back(std::abs(line.residual(p)));
  }
  variance *= scatter * scatter;
  if (!with_slope) variance += usual * usual * drift_share * drift_share;
  for (const double value : bias) variance += value * value;
  const double residual = sizes.size() < 3 ? own_sigma : sigma_per_median * upper_median(sizes);

  const double at_reference = line.at_middle + line.slope * static_cast<double>(saturating_subtract(reference_us, middle_us));
  constexpr double furthest_us = 9e18;  // of int64's 9.22e18
  if (!(std::abs(at_reference) < furthest_us)) return refuse("the two clocks lie further apart than 64 bits of microseconds");
  const std::int64_t offset_us = saturating_add(base_us, std::llround(at_reference));
  const std::int64_t half_us = std::max<std::int64_t>(1, std::llround(normal_95 * std::sqrt(variance)));
  FittedClock clock;
  clock.relation = {.offset_us = offset_us, .drift_ppm = 1e6 * line.slope, .reference_us = reference_us};
  clock.residual_us = residual;
  clock.offset_low_us = saturating_subtract(offset_us, half_us);
  clock.offset_high_us = saturating_add(offset_us, half_us);
  clock.anchors = static_cast<int>(sizes.size());
  clock.method = kinds_text(anchors, fit.used);
  if (!with_slope) clock.method += fmt::format("; drift taken as 0: {}", why_no_drift);
  fit.clock = std::move(clock);
  return fit;
}

}  // namespace tactile
