#include "tactile/robot/speed_profile.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/robot/least_squares.hpp"
#include "tactile/robot/main_direction.hpp"

namespace tactile {
namespace {

using Speed = SpeedProfile::Speed;
using Vector = std::vector<double>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;  // one for each of the log's

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double least_spacing_s = 5e-4;  // of knots
constexpr double faded = 12.0;            // decays after which nothing of a ringing is left

// What is known of arms before one has been seen: they ring at some 5 to 50 Hz, for 20 to 300 ms, with a part of what they are
// driven with. Only an arm whose rows do not tell is taken for such.
constexpr double slowest_ringing_hz = 3.0, fastest_ringing_hz = 60.0;  // what is slower, faster or lasts longer is something else
constexpr double shortest_decay_s = 0.01, longest_decay_s = 0.5;
constexpr double fastest_seen = 0.45;               // periods from row to row
constexpr double usual_hz = 18.0, hz_spread = 0.7;  // of the logarithm
constexpr double usual_decay_s = 0.08, decay_spread = 0.7;
constexpr double usual_share = 0.2, share_spread = 1.2;  // of its log-odds: no mass swings with more than it is driven with

double log_odds(double share) { return std::log(share / (1.0 - share)); }
double share_of(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

/// x' of ArmRinging for a change of 1, without its share.
double swing(double since_s, double w, double decay_s) {
  if (since_s <= 0 || since_s > faded * decay_s) return 0.0;
  return -std::exp(-since_s / decay_s) * std::sin(w * since_s) / w;
}

/// x likewise.
double swung_way(double since_s, double w, double decay_s) {
  if (since_s <= 0) return 0.0;
  const double d = 1.0 / decay_s, size = 1.0 / (w * w + d * d);
  if (since_s > faded * decay_s) return -size;
  return -size * (1.0 - std::exp(-d * since_s) * (std::cos(w * since_s) + d / w * std::sin(w * since_s)));
}

/// The way of a speed that rises from 0 at `from_s` with `slope` until `to_s`, and is 0 outside; back likewise.
double rising_way(double t, double from_s, double to_s, double slope) {
  const double since = std::clamp(t, from_s, to_s) - from_s;
  return 0.5 * slope * since * since;
}
double falling_way(double t, double from_s, double to_s, double slope) {
  const double left = to_s - std::clamp(t, from_s, to_s);
  return 0.5 * slope * ((to_s - from_s) * (to_s - from_s) - left * left);
}

double usual_step_s(const Vector& times) {
  return times.size() < 2 ? 0.008 : (times.back() - times.front()) / static_cast<double>(times.size() - 1);
}

/// Which knots have a speed of their own: all but the ends that are at rest.
bool is_free(std::size_t knot, std::size_t knots, bool open_begin, bool open_end) {
  return (knot > 0 || open_begin) && (knot + 1 < knots || open_end);
}

/// The profile without its speeds, and how it is fitted. Parameters: the knots, then log w, log decay, log-odds of the share.
class Fit {
 public:
  /// @param values  speeds: 1 or 3 axes of each row
  Fit(const Vector& times, const Rows& values, const SpeedProfileOptions& options)
      : times_(times),
        values_(values),
        noise_(options.noise),
        smoothed_s_(options.smoothed_s),
        open_begin_(options.open_begin),
        open_end_(options.open_end),
        most_log_w_(std::log(2.0 * std::numbers::pi * std::min(fastest_ringing_hz, fastest_seen / usual_step_s(times)))),
        weights_(Eigen::VectorXd::Ones(values.rows())) {}

  void set_knots(std::size_t knots) {
    knots_ = knots;
    free_.clear();
    for (std::size_t k = 0; k < knots; ++k) {
      if (is_free(k, knots, open_begin_, open_end_)) free_.push_back(k);
    }
    basis_ = Rows::Zero(values_.rows(), static_cast<Eigen::Index>(free_.size()));
    swings_.assign(knots, Swings{.of_rows = Vector(times_.size(), 0.0)});
  }

  std::size_t parameters() const { return knots_ + 3; }
  double degrees_of_freedom() const {
    const auto used = static_cast<Eigen::Index>(parameters()) + basis_.cols() * values_.cols();
    return static_cast<double>(std::max<Eigen::Index>(values_.size() - used, 1));
  }

  /// Leaves the best speeds. @return the sum of squares reached
  double descend(Vector& parameters, int iterations) {
    const double cost = tactile::descend(problem(), parameters, iterations);
    fit_speeds(parameters);
    return cost;
  }

  /// Counts rows the less, the farther they lie beyond three times the usual distance.
  void weigh_rows() {
    const Eigen::VectorXd distances = left_.rowwise().norm();
    const double usual = std::max(upper_median({distances.data(), times_.size()}) * (values_.cols() == 1 ? 1.48 : 0.65), noise_) *
                         std::sqrt(static_cast<double>(values_.cols()));
    weights_ = (3.0 * usual / distances.array().max(1e-12)).min(1.0);
  }

  /// Mean square of a row and axis over the noise's, at the last parameters.
  double misfit() const { return weights_.dot(left_.rowwise().squaredNorm()) / (noise_ * noise_ * degrees_of_freedom()); }

  double misfit_at(const Vector& parameters) { return fit_speeds(parameters) ? misfit() : infinite; }

  /// By which neighbours that err alike widen a variance: (1 + r) / (1 - r) of the correlation r from row to row.
  double likeness_factor() const {
    const Rows weighed = weights_.cwiseSqrt().asDiagonal() * left_;
    const Eigen::Index pairs = weighed.rows() - 1;
    const double products = weighed.topRows(pairs).cwiseProduct(weighed.bottomRows(pairs)).sum(), squares = weighed.squaredNorm();
    const double r = squares > 0 ? std::clamp(products / squares, 0.0, 0.95) : 0.0;
    return (1.0 + r) / (1.0 - r);
  }

  /// Of the knots, from the curvature at the parameters; empty if it is singular.
  Vector covariance_at(const Vector& parameters) {
    if (!fit_speeds(parameters)) return {};
    const auto n = static_cast<Eigen::Index>(parameters.size()), knots = static_cast<Eigen::Index>(knots_);
    const Vector squares = curvature_at(problem(), parameters);
    fit_speeds(parameters);
    Eigen::MatrixXd curvature = Eigen::MatrixXd::Map(squares.data(), n, n);
    curvature.diagonal() *= 1.0 + 1e-9;
    curvature.diagonal().head(knots).array() += 1.0;  // no knot is worse than a second
    const Eigen::LLT<Eigen::MatrixXd> factor(curvature);
    if (factor.info() != Eigen::Success) return {};
    Eigen::MatrixXd covariance = factor.solve(Eigen::MatrixXd::Identity(n, n)).topLeftCorner(knots, knots);
    for (std::size_t k = 0; k < knots_; ++k) {
      if (!is_held(k)) continue;
      covariance.row(static_cast<Eigen::Index>(k)).setZero();
      covariance.col(static_cast<Eigen::Index>(k)).setZero();
    }
    return {covariance.data(), covariance.data() + covariance.size()};
  }

  double speed(std::size_t knot, std::size_t axis) const {
    const auto found = std::find(free_.begin(), free_.end(), knot);
    return found == free_.end() ? 0.0 : speeds_(found - free_.begin(), static_cast<Eigen::Index>(axis));
  }

 private:
  /// An open end's knot is where the rows begin or end.
  bool is_held(std::size_t knot) const { return (knot == 0 && open_begin_) || (knot + 1 == knots_ && open_end_); }

  LeastSquares problem() {
    LeastSquares squares{
        .residuals = [this](std::span<const double> at, Vector& residuals) { return residuals_of(at, residuals); },
        .steps = Vector(parameters(), 1e-3)};
    for (std::size_t k = 0; k < knots_; ++k) squares.steps[k] = is_held(k) ? 0.0 : 2e-5;
    return squares;
  }

  /// Of the rows, weighed and in units of the noise, for the best speeds; then how far the ringing is from what is usual.
  bool residuals_of(std::span<const double> parameters, Vector& residuals) {
    if (!fit_speeds(parameters)) return false;
    residuals.resize(times_.size() * static_cast<std::size_t>(values_.cols()) + 3);
    Rows::Map(residuals.data(), values_.rows(), values_.cols()) = (weights_.cwiseSqrt() / noise_).asDiagonal() * left_;
    double* priors = residuals.data() + values_.size();
    priors[0] = (parameters[knots_] - std::log(2.0 * std::numbers::pi * usual_hz)) / hz_spread;
    priors[1] = (parameters[knots_ + 1] - std::log(usual_decay_s)) / decay_spread;
    priors[2] = (parameters[knots_ + 2] - log_odds(usual_share)) / share_spread;
    return true;
  }

  /// The best speeds at these parameters, and what they leave of the rows. @return false where the parameters cannot be
  bool fit_speeds(std::span<const double> parameters) {
    for (std::size_t k = 1; k < knots_; ++k) {
      if (!(parameters[k] - parameters[k - 1] >= least_spacing_s)) return false;
    }
    const double log_w = parameters[knots_], odds = parameters[knots_ + 2];
    if (!(std::abs(odds) < 20.0 && log_w < most_log_w_)) return false;
    const double w = std::exp(log_w), decay_s = std::exp(parameters[knots_ + 1]);
    if (!(w >= 2.0 * std::numbers::pi * slowest_ringing_hz && decay_s >= shortest_decay_s && decay_s <= longest_decay_s))
      return false;
    fill_basis(parameters, w, decay_s, share_of(odds));
    const Rows weighed = weights_.asDiagonal() * basis_;
    Eigen::MatrixXd gram = basis_.transpose() * weighed;
    gram.diagonal() *= 1.0 + 1e-9;
    gram.diagonal().array() += 1e-9;
    const Eigen::LLT<Eigen::MatrixXd> factor(gram);
    if (factor.info() != Eigen::Success) return false;
    speeds_ = factor.solve(weighed.transpose() * values_);
    left_ = values_ - basis_ * speeds_;
    return speeds_.allFinite();
  }

  /// How the rows swing after a change of 1 at each knot. Most steps change few of the knots.
  void fill_swings(std::span<const double> knots, double w, double decay_s) {
    for (std::size_t k = 0; k < knots_; ++k) {
      Swings& swings = swings_[k];
      if (is_held(k) || (swings.at_s == knots[k] && swings.w == w && swings.decay_s == decay_s)) continue;
      swings.at_s = knots[k];
      swings.w = w;
      swings.decay_s = decay_s;
      for (std::size_t i = 0; i < times_.size(); ++i) {
        const double since = times_[i] - knots[k];
        swings.of_rows[i] =
            smoothed_s_ > 0
                ? (swung_way(since + smoothed_s_, w, decay_s) - swung_way(since - smoothed_s_, w, decay_s)) / (2.0 * smoothed_s_)
                : swing(since, w, decay_s);
      }
    }
  }

  void fill_basis(std::span<const double> knots, double w, double decay_s, double share) {
    fill_swings(knots, w, decay_s);
    for (std::size_t m = 0; m < free_.size(); ++m) {
      const std::size_t k = free_[m];
      const double rise = k > 0 ? 1.0 / (knots[k] - knots[k - 1]) : 0.0;
      const double fall = k + 1 < knots_ ? 1.0 / (knots[k + 1] - knots[k]) : 0.0;
      const double* before = swings_[k > 0 ? k - 1 : k].of_rows.data();
      const double* here = swings_[k].of_rows.data();
      const double* after = swings_[k + 1 < knots_ ? k + 1 : k].of_rows.data();
      for (std::size_t i = 0; i < times_.size(); ++i) {
        const double t = times_[i];
        double value = share * (rise * (before[i] - here[i]) + fall * (after[i] - here[i]));
        if (smoothed_s_ > 0) {
          const auto way = [&](double at) {
            double gone = 0;
            if (k > 0) gone += rising_way(at, knots[k - 1], knots[k], rise);
            if (k + 1 < knots_) gone += falling_way(at, knots[k], knots[k + 1], fall);
            if (k == 0) gone += std::min(0.0, at - knots[0]);
            if (k + 1 == knots_) gone += std::max(0.0, at - knots[k]);
            return gone;
          };
          value += (way(t + smoothed_s_) - way(t - smoothed_s_)) / (2.0 * smoothed_s_);
        } else {
          if (k > 0 && t > knots[k - 1] && t <= knots[k]) value += rise * (t - knots[k - 1]);
          if (k + 1 < knots_ && t > knots[k] && t < knots[k + 1]) value += fall * (knots[k + 1] - t);
          if (k == 0 && t <= knots[0]) value += 1.0;
          if (k + 1 == knots_ && t > knots[k]) value += 1.0;
        }
        basis_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(m)) = value;
      }
    }
  }

  const Vector& times_;
  const Rows& values_;
  double noise_, smoothed_s_;
  bool open_begin_, open_end_;
  double most_log_w_;
  std::size_t knots_ = 0;
  std::vector<std::size_t> free_;
  Eigen::VectorXd weights_;
  Eigen::MatrixXd speeds_;  ///< of the free knots
  Rows basis_, left_;       ///< what a speed of 1 at each free knot does to the rows; what the last speeds leave of them
  struct Swings {
    double at_s = infinite, w = 0, decay_s = 0;  ///< what they were worked out for
    Vector of_rows;
  };
  std::vector<Swings> swings_;
};

/// The one axis that the rows move along, if they move along one.
std::optional<Speed> common_axis(std::span<const SpeedRow> rows, double noise) {
  std::vector<Speed> speeds;
  for (const SpeedRow& row : rows) speeds.push_back(row.speed);
  const MainDirection main = main_direction(speeds);
  const double by_chance = 2.0 * noise * noise * static_cast<double>(rows.size());
  if (main.across > 2.0 * by_chance + 1e-4 * main.along) return std::nullopt;
  return main.axis;
}

constexpr double well_fitted = 1.5;  // a row's mean square over the noise's: more asks for another knot
constexpr double close_steps = 4.0;  // of rows: knots that are closer may be one

/// Less is better: how far the rows lie off, and how much it took.
double information_criterion(double cost, std::size_t values, std::size_t parameters) {
  const auto n = static_cast<double>(values);
  return n * std::log(std::max(cost, 1e-300) / n) + static_cast<double>(parameters) * std::log(n);
}

/// Where the ways down from some usual ringings led.
struct Descent {
  Vector best;
  double cost = infinite;
  std::vector<std::pair<double, Vector>> ways;  ///< the best few, if they had to be looked for
};

std::optional<Descent> descend_from(Fit& fit, const Vector& knots, const std::optional<ArmRinging>& known, double step_s) {
  fit.set_knots(knots.size());
  const auto from = [&](const ArmRinging& ringing) {
    Vector parameters = knots;
    parameters.insert(parameters.end(), {std::log(2.0 * std::numbers::pi * ringing.hz), std::log(ringing.decay_s),
                                         log_odds(std::clamp(ringing.share, 0.01, 0.9))});
    return parameters;
  };
  Descent descent;
  if (known) {
    descent.best = from(*known);
    descent.cost = fit.descend(descent.best, 40);
    if (descent.cost < infinite && fit.misfit_at(descent.best) <= well_fitted) return descent;
  }
  for (const double hz : {5.0, 8.0, 12.0, 18.0, 27.0, 40.0}) {
    if (hz > 10.0 && hz * step_s > fastest_seen) continue;
    Vector parameters = from({.hz = hz, .decay_s = usual_decay_s, .share = usual_share});
    const double cost = fit.descend(parameters, 6);
    descent.ways.emplace_back(cost, std::move(parameters));
  }
  std::sort(descent.ways.begin(), descent.ways.end());
  descent.ways.resize(std::min<std::size_t>(descent.ways.size(), 3));
  for (auto& [cost, parameters] : descent.ways) {
    cost = fit.descend(parameters, 40);
    if (!(cost < descent.cost)) continue;
    descent.cost = cost;
    descent.best = parameters;
  }
  if (!(descent.cost < infinite)) return std::nullopt;
  return descent;
}

/// Other ways down that fit nearly as well say that a knot may be there as well: their spread, by their likelihoods, widens its
/// variance.
void add_rivals(SpeedProfile& profile, const std::vector<std::pair<double, Vector>>& ways, double misfit) {
  const std::size_t knots = profile.knots_s.size();
  double least = infinite, all = 0;
  const auto has_same_knots = [&](const Vector& parameters) { return parameters.size() == knots + 3; };
  for (const auto& [cost, parameters] : ways) {
    if (has_same_knots(parameters)) least = std::min(least, cost);
  }
  for (const auto& [cost, parameters] : ways) all += has_same_knots(parameters) ? std::exp(-0.5 * (cost - least) / misfit) : 0.0;
  for (const auto& [cost, parameters] : ways) {
    if (!has_same_knots(parameters)) continue;
    const double share = std::exp(-0.5 * (cost - least) / misfit) / all;
    for (std::size_t k = 0; k < knots; ++k) {
      const double off = parameters[k] - profile.knots_s[k];
      profile.covariance[k * knots + k] += share * off * off;
    }
  }
}

}  // namespace

Speed SpeedProfile::commanded_at(double t_s) const {
  Speed speed{};
  if (knots_s.empty() || t_s < knots_s.front() || t_s > knots_s.back()) return speed;
  const auto after = std::upper_bound(knots_s.begin(), knots_s.end(), t_s);
  if (after == knots_s.end()) return speeds.back();
  const auto k = static_cast<std::size_t>(after - knots_s.begin());
  const double share = (t_s - knots_s[k - 1]) / (knots_s[k] - knots_s[k - 1]);
  for (std::size_t a = 0; a < 3; ++a) speed[a] = speeds[k - 1][a] + share * (speeds[k][a] - speeds[k - 1][a]);
  return speed;
}

Speed SpeedProfile::ringing_at(double t_s) const {
  Speed speed{};
  const double w = 2.0 * std::numbers::pi * ringing.hz;
  for (std::size_t k = 0; k < knots_s.size(); ++k) {
    if ((k == 0 && open_begin) || (k + 1 == knots_s.size() && open_end)) continue;
    const double swings = ringing.share * swing(t_s - knots_s[k], w, ringing.decay_s);
    if (swings == 0.0) continue;
    for (std::size_t a = 0; a < 3; ++a) {
      double change = 0;
      if (k > 0) change -= (speeds[k][a] - speeds[k - 1][a]) / (knots_s[k] - knots_s[k - 1]);
      if (k + 1 < knots_s.size()) change += (speeds[k + 1][a] - speeds[k][a]) / (knots_s[k + 1] - knots_s[k]);
      speed[a] += change * swings;
    }
  }
  return speed;
}

double SpeedProfile::sigma_s(std::size_t knot) const { return std::sqrt(covariance[knot * knots_s.size() + knot]); }

std::optional<SpeedProfile> fit_speed_profile(std::span<const SpeedRow> rows, const SpeedProfileOptions& options) {
  assert(options.knots_s.size() >= 3 && "a motion has a start, a middle and an end");
  const std::optional<Speed> axis = common_axis(rows, options.noise);
  const std::size_t axes = axis ? 1 : 3;
  Vector times;
  Rows values(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(axes));
  for (const SpeedRow& row : rows) {
    const auto speed = Eigen::RowVector3d::Map(row.speed.data());
    const auto i = static_cast<Eigen::Index>(times.size());
    times.push_back(row.t_s);
    if (axis) {
      values(i, 0) = speed.dot(Eigen::RowVector3d::Map(axis->data()));
    } else {
      values.row(i) = speed;
    }
  }
  if (times.size() < options.knots_s.size() + 6) return std::nullopt;
  const auto criterion = [&](double cost, std::size_t count) {
    return information_criterion(cost, times.size() * axes, count + 3 + axes * count);
  };
  Fit fit(times, values, options);
  std::optional<Descent> descent = descend_from(fit, options.knots_s, options.ringing, usual_step_s(times));
  if (options.other_knots_s.size() >= 3 && times.size() >= options.other_knots_s.size() + 6 &&
      (!descent || fit.misfit_at(descent->best) > well_fitted)) {
    const std::optional<Descent> other = descend_from(fit, options.other_knots_s, options.ringing, usual_step_s(times));
    if (other &&
        (!descent || criterion(other->cost, options.other_knots_s.size()) < criterion(descent->cost, options.knots_s.size())))
      descent = other;
  }
  if (!descent) return std::nullopt;
  Vector best = descent->best;
  double best_cost = descent->cost;
  std::size_t knots = best.size() - 3;
  fit.set_knots(knots);
  if (fit.misfit_at(best) > well_fitted) {  // by single rows perhaps
    fit.weigh_rows();
    best_cost = fit.descend(best, 20);
  }

  // Straight lines that do not do get a knot more, where it does most.
  while (knots < options.most_knots && times.size() > 2 * (knots + 1) && fit.misfit_at(best) > well_fitted) {
    Fit more = fit;
    more.set_knots(knots + 1);
    Vector with_more;
    double with_more_cost = infinite;
    const auto try_with = [&](Vector parameters) {
      const double cost = more.descend(parameters, 4);
      if (!(cost < with_more_cost)) return;
      with_more_cost = cost;
      with_more = std::move(parameters);
    };
    for (std::size_t k = 0; k + 1 < knots; ++k) {  // between two, and one split in two
      const auto place = static_cast<std::ptrdiff_t>(k) + 1;
      Vector between = best, split = best;
      between.insert(between.begin() + place, 0.5 * (best[k] + best[k + 1]));
      try_with(std::move(between));
      if (k == 0) continue;
      const double apart = 0.2 * std::min(best[k] - best[k - 1], best[k + 1] - best[k]);
      split[k] -= apart;
      split.insert(split.begin() + place, best[k] + apart);
      try_with(std::move(split));
    }
    if (!(with_more_cost < infinite)) break;
    with_more_cost = more.descend(with_more, 40);
    if (criterion(with_more_cost, knots + 1) > criterion(best_cost, knots) - 10.0) break;
    fit.set_knots(++knots);
    best = with_more;
    best_cost = fit.descend(best, 1);
  }
  // Two that have come together are one.
  for (std::size_t k = 0; knots > 3 && k + 1 < knots;) {
    const bool close = best[k + 1] - best[k] < close_steps * usual_step_s(times);
    if (!close) {
      ++k;
      continue;
    }
    Fit less = fit;
    less.set_knots(knots - 1);
    Vector parameters = best;
    const bool keeps_first = k == 0, keeps_last = k + 2 == knots;
    if (!keeps_first && !keeps_last) parameters[k] = 0.5 * (best[k] + best[k + 1]);
    parameters.erase(parameters.begin() + static_cast<std::ptrdiff_t>(keeps_last ? k : k + 1));
    const double cost = less.descend(parameters, 40);
    if (!(criterion(cost, knots - 1) < criterion(best_cost, knots))) {
      ++k;
      continue;
    }
    fit.set_knots(--knots);
    best = parameters;
    best_cost = fit.descend(best, 1);
    k = 0;
  }
  for (int round = 0; round < 2; ++round) {
    fit.weigh_rows();
    best_cost = fit.descend(best, 20);
  }

  SpeedProfile profile;
  profile.knots_s.assign(best.begin(), best.begin() + static_cast<std::ptrdiff_t>(knots));
  profile.open_begin = options.open_begin;
  profile.open_end = options.open_end;
  profile.ringing = {.hz = std::exp(best[knots]) / (2.0 * std::numbers::pi),
                     .decay_s = std::exp(best[knots + 1]),
                     .share = share_of(best[knots + 2])};
  profile.covariance = fit.covariance_at(best);
  if (profile.covariance.empty()) return std::nullopt;
  const double misfit = fit.misfit(), factor = std::max(1.0, misfit) * fit.likeness_factor();
  for (double& value : profile.covariance) value *= factor;
  add_rivals(profile, descent->ways, std::max(1.0, misfit));
  profile.speed_sigma = options.noise * std::sqrt(misfit);
  for (std::size_t k = 0; k < knots; ++k) {
    Speed speed{};
    for (std::size_t a = 0; a < 3; ++a) speed[a] = axis ? fit.speed(k, 0) * (*axis)[a] : fit.speed(k, a);
    profile.speeds.push_back(speed);
  }
  return profile;
}

}  // namespace tactile
