#include "tactile/alignment/speed_profile_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tactile/core/infinite.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::alignment {
namespace {

using Vector = std::vector<double>;

constexpr double least_spacing_s = 5e-4;  // of knots

// Known of arms in general: they ring at some 5 to 50 Hz, for 20 to 300 ms, with a part of the acceleration. This decides only
// where the rows do not.
constexpr double slowest_ringing_hz = 3.0, fastest_ringing_hz = 60.0;
constexpr double shortest_decay_s = 0.01, longest_decay_s = 0.5;
constexpr double usual_hz = 18.0, hz_spread = 0.7;  // of the logarithm
constexpr double decay_spread = 0.7;
constexpr double share_spread = 1.2;  // of its log-odds

double log_odds(double share) { return std::log(share / (1.0 - share)); }
double share_of(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

/// x' of ArmRinging for a change of 1 and a share of 1.
double ringing_speed(double since_s, double w, double decay_s) {
  if (since_s <= 0 || since_s > faded * decay_s) return 0.0;
  return -std::exp(-since_s / decay_s) * std::sin(w * since_s) / w;
}

/// Its integral x.
double ringing_displacement(double since_s, double w, double decay_s) {
  if (since_s <= 0) return 0.0;
  const double d = 1.0 / decay_s, size = 1.0 / (w * w + d * d);
  if (since_s > faded * decay_s) return -size;
  return -size * (1.0 - std::exp(-d * since_s) * (std::cos(w * since_s) + d / w * std::sin(w * since_s)));
}

}  // namespace

double usual_step_s(const Vector& times) {
  return times.size() < 2 ? 0.008 : (times.back() - times.front()) / static_cast<double>(times.size() - 1);
}

SpeedProfileFit::SpeedProfileFit(const Vector& times, const SpeedMatrix& values, const SpeedProfileOptions& options)
    : times_(times),
      values_(values),
      noise_(options.noise),
      smoothed_s_(options.smoothed_s),
      open_begin_(options.open_begin),
      open_end_(options.open_end),
      most_log_w_(std::log(2.0 * std::numbers::pi * std::min(fastest_ringing_hz, fastest_seen / usual_step_s(times)))),
      weights_(Eigen::VectorXd::Ones(values.rows())) {}

void SpeedProfileFit::set_knots(std::size_t knots) {
  knots_ = knots;
  free_.clear();
  for (std::size_t k = 0; k < knots; ++k) {
    if ((k > 0 || open_begin_) && (k + 1 < knots || open_end_)) free_.push_back(k);
  }
  basis_ = SpeedMatrix::Zero(values_.rows(), static_cast<Eigen::Index>(free_.size()));
  responses_.assign(knots, Response{.of_rows = Vector(times_.size(), 0.0)});
}

Vector SpeedProfileFit::parameters_of(const Vector& knots, const ArmRinging& ringing) const {
  Vector parameters = knots;
  parameters.insert(parameters.end(), {std::log(2.0 * std::numbers::pi * ringing.hz), std::log(ringing.decay_s),
                                       log_odds(std::clamp(ringing.share, 0.01, 0.9))});
  return parameters;
}

ArmRinging SpeedProfileFit::ringing_of(std::span<const double> parameters) const {
  return {.hz = std::exp(parameters[knots_]) / (2.0 * std::numbers::pi),
          .decay_s = std::exp(parameters[knots_ + 1]),
          .share = share_of(parameters[knots_ + 2])};
}

double SpeedProfileFit::descend(Vector& parameters, int iterations) {
  const double cost = tactile::alignment::descend(problem(), parameters, iterations);
  fit_speeds(parameters);
  return cost;
}

void SpeedProfileFit::weigh_rows() {
  const Eigen::VectorXd distances = residuals_.rowwise().norm();
  const double usual = std::max(median({distances.data(), times_.size()}) * (values_.cols() == 1 ? 1.48 : 0.65), noise_) *
                       std::sqrt(static_cast<double>(values_.cols()));
  weights_ = (3.0 * usual / distances.array().max(1e-12)).min(1.0);
}

double SpeedProfileFit::degrees_of_freedom() const {
  const auto used = static_cast<Eigen::Index>(knots_ + 3) + basis_.cols() * values_.cols();
  return static_cast<double>(std::max<Eigen::Index>(values_.size() - used, 1));
}

double SpeedProfileFit::misfit() const {
  return weights_.dot(residuals_.rowwise().squaredNorm()) / (noise_ * noise_ * degrees_of_freedom());
}

double SpeedProfileFit::misfit_at(const Vector& parameters) { return fit_speeds(parameters) ? misfit() : infinite; }

double SpeedProfileFit::correlation_factor() const {
  const SpeedMatrix weighted = weights_.cwiseSqrt().asDiagonal() * residuals_;
  const Eigen::Index pairs = weighted.rows() - 1;
  const double products = weighted.topRows(pairs).cwiseProduct(weighted.bottomRows(pairs)).sum();
  const double squares = weighted.squaredNorm();
  const double r = squares > 0 ? std::clamp(products / squares, 0.0, 0.95) : 0.0;
  return (1.0 + r) / (1.0 - r);
}

Vector SpeedProfileFit::covariance_at(const Vector& parameters) {
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

double SpeedProfileFit::speed(std::size_t knot, std::size_t axis) const {
  const auto found = std::find(free_.begin(), free_.end(), knot);
  return found == free_.end() ? 0.0 : speeds_(found - free_.begin(), static_cast<Eigen::Index>(axis));
}

LeastSquares SpeedProfileFit::problem() {
  LeastSquares squares{.residuals = [this](std::span<const double> at, Vector& residuals) { return residuals_of(at, residuals); },
                       .steps = Vector(knots_ + 3, 1e-3)};
  for (std::size_t k = 0; k < knots_; ++k) squares.steps[k] = is_held(k) ? 0.0 : 2e-5;
  return squares;
}

/// Of the rows for the best speeds, weighted and in units of the noise; then of the ringing against the usual one.
bool SpeedProfileFit::residuals_of(std::span<const double> parameters, Vector& residuals) {
  if (!fit_speeds(parameters)) return false;
  residuals.resize(times_.size() * static_cast<std::size_t>(values_.cols()) + 3);
  SpeedMatrix::Map(residuals.data(), values_.rows(), values_.cols()) = (weights_.cwiseSqrt() / noise_).asDiagonal() * residuals_;
  double* priors = residuals.data() + values_.size();
  priors[0] = (parameters[knots_] - std::log(2.0 * std::numbers::pi * usual_hz)) / hz_spread;
  priors[1] = (parameters[knots_ + 1] - std::log(usual_decay_s)) / decay_spread;
  priors[2] = (parameters[knots_ + 2] - log_odds(usual_share)) / share_spread;
  return true;
}

/// Sets the best speeds at these parameters, and their residuals. @return false where the parameters are impossible
bool SpeedProfileFit::fit_speeds(std::span<const double> parameters) {
  for (std::size_t k = 1; k < knots_; ++k) {
    if (!(parameters[k] - parameters[k - 1] >= least_spacing_s)) return false;
  }
  const double log_w = parameters[knots_], odds = parameters[knots_ + 2];
  if (!(std::abs(odds) < 20.0 && log_w < most_log_w_)) return false;
  const double w = std::exp(log_w), decay_s = std::exp(parameters[knots_ + 1]);
  if (!(w >= 2.0 * std::numbers::pi * slowest_ringing_hz && decay_s >= shortest_decay_s && decay_s <= longest_decay_s))
    return false;
  fill_basis(parameters.first(knots_), w, decay_s, share_of(odds));
  const SpeedMatrix weighted = weights_.asDiagonal() * basis_;
  Eigen::MatrixXd gram = basis_.transpose() * weighted;
  gram.diagonal() *= 1.0 + 1e-9;
  gram.diagonal().array() += 1e-9;
  const Eigen::LLT<Eigen::MatrixXd> factor(gram);
  if (factor.info() != Eigen::Success) return false;
  speeds_ = factor.solve(weighted.transpose() * values_);
  residuals_ = values_ - basis_ * speeds_;
  return speeds_.allFinite();
}

/// Most steps of a descent change few of the knots: only those are computed again.
void SpeedProfileFit::update_responses(std::span<const double> knots, double w, double decay_s) {
  for (std::size_t k = 0; k < knots_; ++k) {
    Response& response = responses_[k];
    if (is_held(k) || (response.at_s == knots[k] && response.w == w && response.decay_s == decay_s)) continue;
    response.at_s = knots[k];
    response.w = w;
    response.decay_s = decay_s;
    for (std::size_t i = 0; i < times_.size(); ++i) {
      const double since = times_[i] - knots[k];
      response.of_rows[i] =
          smoothed_s_ > 0
              ? (ringing_displacement(since + smoothed_s_, w, decay_s) - ringing_displacement(since - smoothed_s_, w, decay_s)) /
                    (2.0 * smoothed_s_)
              : ringing_speed(since, w, decay_s);
    }
  }
}

/// The commanded speed where that of `knot` is 1 and those of the others are 0; 1 beyond an open end's knot.
double SpeedProfileFit::command_at(std::span<const double> knots, std::size_t knot, double t) const {
  const double at = knots[knot];
  if (t <= at) {
    if (knot == 0) return 1.0;
    return t > knots[knot - 1] ? (t - knots[knot - 1]) / (at - knots[knot - 1]) : 0.0;
  }
  if (knot + 1 == knots_) return 1.0;
  return t < knots[knot + 1] ? (knots[knot + 1] - t) / (knots[knot + 1] - at) : 0.0;
}

/// Its integral from the knot before, if there is one, else from the knot.
double SpeedProfileFit::command_displacement(std::span<const double> knots, std::size_t knot, double t) const {
  const double at = knots[knot];
  double moved = 0;
  if (knot > 0) {
    const double length = at - knots[knot - 1], since = std::clamp(t, knots[knot - 1], at) - knots[knot - 1];
    moved += 0.5 * since * since / length;
  } else {
    moved += std::min(0.0, t - at);
  }
  if (knot + 1 < knots_) {
    const double length = knots[knot + 1] - at, left = knots[knot + 1] - std::clamp(t, at, knots[knot + 1]);
    moved += 0.5 * (length * length - left * left) / length;
  } else {
    moved += std::max(0.0, t - at);
  }
  return moved;
}

void SpeedProfileFit::fill_basis(std::span<const double> knots, double w, double decay_s, double share) {
  update_responses(knots, w, decay_s);
  for (std::size_t m = 0; m < free_.size(); ++m) {
    const std::size_t k = free_[m], before = k > 0 ? k - 1 : k, after = k + 1 < knots_ ? k + 1 : k;
    const double rise = k > 0 ? 1.0 / (knots[k] - knots[before]) : 0.0;
    const double fall = k + 1 < knots_ ? 1.0 / (knots[after] - knots[k]) : 0.0;
    const double *rung_before = responses_[before].of_rows.data(), *rung = responses_[k].of_rows.data(),
                 *rung_after = responses_[after].of_rows.data();
    for (std::size_t i = 0; i < times_.size(); ++i) {
      const double t = times_[i], ringing = share * (rise * (rung_before[i] - rung[i]) + fall * (rung_after[i] - rung[i]));
      const double command =
          smoothed_s_ > 0 ? (command_displacement(knots, k, t + smoothed_s_) - command_displacement(knots, k, t - smoothed_s_)) /
                                (2.0 * smoothed_s_)
                          : command_at(knots, k, t);
      basis_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(m)) = ringing + command;
    }
  }
}

}  // namespace tactile::alignment
