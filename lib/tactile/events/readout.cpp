#include "tactile/events/readout.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>

#include "tactile/core/straight_line.hpp"
#include "tactile/events/stamp_period.hpp"

namespace tactile::events {
namespace {

constexpr double rounding_variance = 1.0 / 12;  // of whole us
constexpr double least_coherence = 0.9;
constexpr double longest_block_us = 100'000;

/// The nearest whole number of |value| < 2^51, without a call of the library.
double rounded(double value) {
  constexpr double no_fractions = 0x1.8p52;
  return value + no_fractions - no_fractions;
}

double wrapped(double value, double period) { return value - period * rounded(value / period); }

/// Where each line lies within the period, as a sum of unit vectors.
using PhaseSums = std::vector<std::complex<double>>;

/// The step from line to line, in periods, that brings the phases of all lines together. A read-out passes each line once, so it
/// is at most 1 / lines.
double step_of(const PhaseSums& phases) {
  const auto lines = static_cast<double>(phases.size());
  double best = 0, most = -1;
  for (int step = -42; step <= 42; ++step) {
    const double turns = 0.025 * step;
    std::complex<double> sum = 0;
    for (std::size_t line = 0; line < phases.size(); ++line)
      sum += phases[line] * std::polar(1.0, -2 * std::numbers::pi * turns / lines * static_cast<double>(line));
    if (std::abs(sum) <= most) continue;
    most = std::abs(sum);
    best = turns / lines;
  }
  return best;
}

/// The standard uncertainty of a gradient through points with weights 1 / variance, which grows by their scatter.
double gradient_uncertainty(std::span<const WeightedPoint> points, const StraightLine& line, double& chi2) {
  chi2 = 0;
  const double white = line.weighted_xx > 0 ? 1 / std::sqrt(line.weighted_xx) : std::numeric_limits<double>::infinity();
  if (points.size() < 3) return white;
  for (const WeightedPoint& p : points) chi2 += p.weight * (p.y - line.at(p.x)) * (p.y - line.at(p.x));
  chi2 /= static_cast<double>(points.size() - 2);
  return white * std::sqrt(std::max(1.0, chi2));
}

/// The same of points that may wander together: that is averaged out by more time, not by more points.
double wandering_gradient_uncertainty(std::span<const WeightedPoint> points, const StraightLine& line) {
  constexpr std::size_t groups = 8;
  double chi2 = 0;
  const double scattered = gradient_uncertainty(points, line, chi2);
  if (chi2 < 2 || points.size() < 4 * groups) return scattered;
  std::vector<double> gradients;
  for (std::size_t i = 0; i < groups; ++i) {
    const std::size_t begin = points.size() * i / groups, end = points.size() * (i + 1) / groups;
    gradients.push_back(line_through(points.subspan(begin, end - begin)).gradient);
  }
  return std::max(scattered, mean_of(gradients).uncertainty);
}

/// The first lag at which the residuals correlate by less than 1 / e; 0 for fewer than 16 points.
double correlation_time(std::span<const WeightedPoint> points, const StraightLine& line) {
  const auto residual = [&](std::size_t i) { return points[i].y - line.at(points[i].x); };
  if (points.size() < 16) return 0;
  const double step = (points.back().x - points.front().x) / static_cast<double>(points.size() - 1);
  double variance = 0;
  for (std::size_t i = 0; i < points.size(); ++i) variance += residual(i) * residual(i);
  std::size_t lag = 1;
  for (; lag < points.size() / 2; ++lag) {
    double sum = 0;
    for (std::size_t i = lag; i < points.size(); ++i) sum += residual(i) * residual(i - lag);
    if (sum < variance / std::numbers::e) break;
  }
  return step * static_cast<double>(lag);
}

}  // namespace

ReadoutMeter::ReadoutMeter(std::optional<SensorSize> size, Extent extent) : extent_(extent) {
  if (size && size->width > 0 && size->height > 0 && size->width <= most_side + 1 && size->height <= most_side + 1) size_ = *size;
}

std::size_t ReadoutMeter::lines_along(Scan scan) const {
  return scan == Scan::none ? 1 : static_cast<std::size_t>(scan == Scan::columns ? size_.width : size_.height);
}

void ReadoutMeter::add(std::span<const Event> events) {
  if (searched_ && extent_ == Extent::beginning) return;
  for (const Event& event : events) {
    if (!first_) first_ = event.t;
    if (size_.width > 0 && (event.x < 0 || event.y < 0 || event.x >= size_.width || event.y >= size_.height)) continue;
    const Stamp stamp{between(*first_, event.t).count(), event.x, event.y};
    ++events_;
    if (step_us_ != 1) step_us_ = std::gcd(step_us_, stamp.t_us);
    if (searched_) {
      if (follower_) follower_->add(stamp);
      continue;
    }
    kept_.push_back(stamp);
    if (kept_.size() < most_kept) continue;
    searched_ = true;
    follower_ = found();
    if (extent_ == Extent::beginning) return;
    if (follower_) kept_ = {};  // otherwise they may still show an unsteady period
  }
}

Readout ReadoutMeter::readout() const {
  const std::optional<Follower> follower = searched_ ? follower_ : found();
  Readout readout;
  if (follower) readout = follower->readout();
  readout.stamp_step_us = step_us_;
  readout.events = events_;
  if (follower) return readout;
  StampDifferences differences(1);
  for (const Stamp& stamp : kept_) differences.add(0, stamp.t_us);
  if (const auto shortest = shortest_period(differences.counts())) {
    readout.kind = Readout::Kind::unsteady;
    readout.period_us = {*shortest, std::sqrt(rounding_variance)};
  }
  return readout;
}

/// The formula for one kind of scan, and how well the kept events follow it.
std::optional<ReadoutMeter::Line> ReadoutMeter::line_along(Scan scan, double& coherence) const {
  constexpr std::size_t most_parts = 32, least_in_part = 50;
  Line line{.scan = scan};
  StampDifferences differences(lines_along(scan));
  for (const Stamp& stamp : kept_) differences.add(line.line_of(stamp), stamp.t_us);
  const auto period = common_period(differences.counts());
  if (!period) return std::nullopt;
  line.period_us = *period;
  const auto phase_of = [&](const Stamp& stamp) {
    return 2 * std::numbers::pi * wrapped(line.after_begin_us(stamp), line.period_us) / line.period_us;
  };
  if (scan != Scan::none) {
    PhaseSums phases(lines_along(scan));
    for (const Stamp& stamp : kept_) phases[line.line_of(stamp)] += std::polar(1.0, phase_of(stamp));
    line.step_us = step_of(phases) * line.period_us;
    const std::complex<double> all =
        std::accumulate(kept_.begin(), kept_.end(), std::complex<double>{},
                        [&](std::complex<double> sum, const Stamp& stamp) { return sum + std::polar(1.0, phase_of(stamp)); });
    line.begin_us = std::arg(all) / (2 * std::numbers::pi) * line.period_us;
    std::vector<WeightedPoint> points;  // the steps that were tried are coarse
    for (std::size_t i = 0; i < phases.size(); ++i) {
      const double n = std::abs(phases[i]);
      if (!(n > 0)) continue;
      const double offset = std::arg(phases[i]) / (2 * std::numbers::pi) * line.period_us;
      const auto c = static_cast<double>(i);
      points.push_back({c, wrapped(offset - line.begin_us - line.step_us * c, line.period_us), n});
    }
    line.step_us += line_through(points).gradient;
    line.begin_us = 0;
  }
  // In parts, since the clock wanders.
  const std::size_t parts = std::clamp<std::size_t>(kept_.size() / least_in_part, 1, most_parts);
  double lengths = 0;
  for (std::size_t part = 0; part < parts; ++part) {
    std::complex<double> sum = 0;
    for (std::size_t i = kept_.size() * part / parts; i < kept_.size() * (part + 1) / parts; ++i)
      sum += std::polar(1.0, phase_of(kept_[i]));
    lengths += std::abs(sum);
    if (part == 0) line.begin_us = std::arg(sum) / (2 * std::numbers::pi) * line.period_us;
    if (part == 0) lengths = std::abs(sum);
  }
  coherence = lengths / static_cast<double>(kept_.size());
  return line;
}

std::optional<ReadoutMeter::Follower> ReadoutMeter::found() const {
  constexpr double least_scan_us = 1.0;
  std::optional<Line> best;
  double best_coherence = least_coherence;
  for (const Scan scan : {Scan::none, Scan::columns, Scan::rows}) {
    if (scan != Scan::none && size_.width == 0) continue;
    double coherence = 0;
    const std::optional<Line> line = line_along(scan, coherence);
    if (!line || coherence < best_coherence) continue;
    // A read-out without a scan looks coherent by column and by row too.
    const bool scans = std::abs(line->step_us) * static_cast<double>(lines_along(scan)) > least_scan_us;
    if (best && (!scans || 1 - coherence > 0.5 * (1 - best_coherence))) continue;
    best = line;
    best_coherence = coherence;
  }
  if (!best) return std::nullopt;
  const double span_us = static_cast<double>(kept_.back().t_us - kept_.front().t_us);
  const double block_us = std::clamp(span_us / 64, std::min(20 * best->period_us, longest_block_us), longest_block_us);
  const auto followed = [&](const Line& line) {
    Follower follower(line, lines_along(line.scan), block_us);
    for (const Stamp& stamp : kept_) follower.add(stamp);
    return follower;
  };
  // Jitter biases the differences of stamps; a wrong period would seem to be jitter within a block.
  const Readout first = followed(*best).readout();
  if (first.kind != Readout::Kind::steady) return std::nullopt;
  best->period_us = first.period_us.value;
  best->begin_us = first.begin_us;
  best->step_us = first.step_us.value;
  return followed(*best);
}

void ReadoutMeter::Follower::add(const Stamp& stamp) {
  const auto t = static_cast<double>(stamp.t_us);
  if (t >= block_end_us_) {
    if (block_.n > 0) {
      expected_us_ += block_.r / block_.n;
      blocks_.push_back(block_);
    }
    block_ = {.shift_us = expected_us_};
    block_end_us_ = (std::floor(t / block_us_) + 1) * block_us_;
  }
  const double r = wrapped(line_.after_begin_us(stamp) - expected_us_, line_.period_us);
  if (std::abs(r) > line_.period_us / 4) return;  // not of a read-out
  const std::size_t place = line_.line_of(stamp);
  const auto c = static_cast<double>(place);
  block_.n += 1;
  block_.t += t;
  block_.r += r;
  block_.rr += r * r;
  block_.c += c;
  block_.cc += c * c;
  block_.cr += c * r;
  line_sums_[place] += r;
  line_counts_[place] += 1;
}

Readout ReadoutMeter::Follower::readout() const {
  constexpr double fewest = 8;
  std::vector<Block> blocks = blocks_;
  blocks.push_back(block_);
  std::erase_if(blocks, [](const Block& block) { return block.n < fewest; });
  Readout readout;
  if (blocks.empty()) return readout;
  readout.kind = Readout::Kind::steady;
  readout.scan = line_.scan;
  readout.lines = line_.scan == Scan::none ? 0 : lines_;
  measure_period(readout, blocks);
  measure_scan(readout, blocks);
  measure_jitter(readout, blocks);
  return readout;
}

void ReadoutMeter::Follower::measure_period(Readout& readout, const std::vector<Block>& blocks) const {
  double variance = rounding_variance, n = 0;  // at least the rounding, since few exact stamps do not show it
  for (const Block& b : blocks) {
    variance += b.rr - b.r * b.r / b.n;
    n += b.n;
  }
  variance = std::max(variance / n, 1e-6);
  std::vector<WeightedPoint> points;
  points.reserve(blocks.size());
  for (const Block& b : blocks) points.push_back({b.t / b.n, b.shift_us + b.r / b.n, b.n / variance});
  const StraightLine line = line_through(points);
  readout.period_us.value = line_.period_us * (1 + line.gradient);
  const bool is_long = points.back().x > points.front().x;
  readout.period_us.uncertainty = is_long ? line_.period_us * wandering_gradient_uncertainty(points, line) : 1.0;
  readout.begin_us = line_.begin_us + line.at(0);
  double squares = 0, expected = 0;
  for (const WeightedPoint& p : points) {
    squares += (p.y - line.at(p.x)) * (p.y - line.at(p.x));
    expected += 1 / p.weight;
  }
  const auto m = static_cast<double>(points.size());
  readout.wander_us.value = std::sqrt(std::max(0.0, squares - expected) / m);
  constexpr double independent = 8;  // of a slow wander
  readout.wander_us.uncertainty =
      std::max(readout.wander_us.value / std::sqrt(2 * std::min(m, independent)), std::sqrt(expected / m / std::sqrt(2 * m)));
  readout.wander_s = correlation_time(points, line) * 1e-6;
}

void ReadoutMeter::Follower::measure_scan(Readout& readout, const std::vector<Block>& blocks) const {
  if (line_.scan == Scan::none) return;
  std::vector<CountPart> parts;  // gradient = sum of c r / sum of c c
  for (const Block& b : blocks) {
    const double cc = b.cc - b.c * b.c / b.n;
    if (cc > 0) parts.push_back({b.cr - b.c * b.r / b.n, cc});
  }
  const Measured correction = ratio_of(parts);
  readout.step_us = {line_.step_us + correction.value, correction.uncertainty};
  readout.line_offsets_us.assign(lines_, std::numeric_limits<double>::quiet_NaN());
  std::vector<WeightedPoint> points;
  for (std::size_t i = 0; i < lines_; ++i) {
    if (line_counts_[i] > 0)
      points.push_back({static_cast<double>(i), line_sums_[i] / line_counts_[i], line_counts_[i] / rounding_variance});
  }
  const StraightLine line = line_through(points);
  double chi2 = 0;  // rounding shifts all stamps of a line alike, which more time does not average out
  readout.step_us.uncertainty = std::max(readout.step_us.uncertainty, gradient_uncertainty(points, line, chi2));
  for (const WeightedPoint& p : points) readout.line_offsets_us[static_cast<std::size_t>(p.x)] = p.y - line.at(p.x);
}

void ReadoutMeter::Follower::measure_jitter(Readout& readout, const std::vector<Block>& blocks) const {
  const bool is_rounded =
      line_.scan != Scan::none ||
      std::abs(readout.period_us.value - std::nearbyint(readout.period_us.value)) > 3 * readout.period_us.uncertainty;
  std::vector<CountPart> parts;
  double n = 0;
  for (const Block& b : blocks) {
    parts.push_back({b.rr - b.r * b.r / b.n, b.n - 1});
    n += b.n;
  }
  Measured variance = ratio_of(parts);
  const double phase = 2 * std::numbers::pi / readout.period_us.value;
  readout.coherence = std::exp(-phase * phase * variance.value / 2);
  if (is_rounded) variance.value -= rounding_variance;
  if (!std::isfinite(variance.uncertainty)) variance.uncertainty = std::abs(variance.value) * std::sqrt(2 / n);
  const double jitter = std::sqrt(std::max(0.0, variance.value));
  readout.jitter_us = {jitter, variance.value > variance.uncertainty ? variance.uncertainty / (2 * jitter)
                                                                     : std::sqrt(std::max(0.0, variance.uncertainty))};
}

}  // namespace tactile::events
