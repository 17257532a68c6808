#include "tactile/alignment/speed_profile.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "tactile/alignment/main_direction.hpp"
#include "tactile/alignment/speed_profile_fit.hpp"
#include "tactile/core/infinite.hpp"

namespace tactile::alignment {
namespace {

using Speed = SpeedProfile::Speed;
using Vector = std::vector<double>;

constexpr double well_fitted = 1.5;  // a row's mean square over that of the noise: above, another knot is tried
constexpr double close_steps = 4.0;  // of rows: knots that are closer may be one

/// The one axis that the rows move along, if they move along one.
std::optional<Speed> common_axis(std::span<const SpeedRow> rows, double noise) {
  std::vector<Speed> speeds;
  for (const SpeedRow& row : rows) speeds.push_back(row.speed);
  const MainDirection main = main_direction(speeds);
  const double by_chance = 2.0 * noise * noise * static_cast<double>(rows.size());
  if (main.across > 2.0 * by_chance + 1e-4 * main.along) return std::nullopt;
  return main.axis;
}

/// Parameters that a descent reached, and their sum of squares.
struct Descent {
  double cost = infinite;
  Vector parameters;
};

/// The rows in the form of the least-squares problem.
struct Rows {
  Vector times;
  SpeedMatrix values;
  std::optional<Speed> axis;

  Rows(std::span<const SpeedRow> rows, double noise) : axis(common_axis(rows, noise)) {
    values.resize(static_cast<Eigen::Index>(rows.size()), axis ? 1 : 3);
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
  }

  /// The Bayesian information criterion of a fit: less is better.
  double criterion(const Descent& descent) const {
    const std::size_t knots = descent.parameters.size() - 3;
    const auto n = static_cast<double>(values.size());
    const auto parameters = static_cast<double>(knots + 3 + static_cast<std::size_t>(values.cols()) * knots);
    return n * std::log(std::max(descent.cost, 1e-300) / n) + parameters * std::log(n);
  }
};

/// The best descent, and the best few of those from usual ringings, if these were needed.
struct Descents {
  Descent best;
  std::vector<Descent> rivals;
};

std::optional<Descents> descend_from(SpeedProfileFit& fit, const Vector& knots, const std::optional<ArmRinging>& known,
                                     double step_s) {
  fit.set_knots(knots.size());
  Descents found;
  if (known) {
    found.best.parameters = fit.parameters_of(knots, *known);
    found.best.cost = fit.descend(found.best.parameters, 40);
    if (found.best.cost < infinite && fit.misfit_at(found.best.parameters) <= well_fitted) return found;
  }
  for (const double hz : {5.0, 8.0, 12.0, 18.0, 27.0, 40.0}) {
    if (hz > 10.0 && hz * step_s > fastest_seen) continue;
    Descent& one = found.rivals.emplace_back();
    one.parameters = fit.parameters_of(knots, {.hz = hz, .decay_s = usual_decay_s, .share = usual_share});
    one.cost = fit.descend(one.parameters, 6);
  }
  std::sort(found.rivals.begin(), found.rivals.end(),
            [](const Descent& a, const Descent& b) { return std::pair(a.cost, a.parameters) < std::pair(b.cost, b.parameters); });
  found.rivals.resize(std::min<std::size_t>(found.rivals.size(), 3));
  for (Descent& one : found.rivals) {
    one.cost = fit.descend(one.parameters, 40);
    if (one.cost < found.best.cost) found.best = one;
  }
  if (!(found.best.cost < infinite)) return std::nullopt;
  return found;
}

/// The descent from the options' knots, or from the other knots if these fit better.
std::optional<Descents> first_descent(SpeedProfileFit& fit, const Rows& rows, const SpeedProfileOptions& options) {
  const double step_s = usual_step_s(rows.times);
  std::optional<Descents> found = descend_from(fit, options.knots_s, options.ringing, step_s);
  const std::size_t others = options.other_knots_s.size();
  if (others < 3 || rows.times.size() < others + 6) return found;
  if (found && fit.misfit_at(found->best.parameters) <= well_fitted) return found;
  const std::optional<Descents> other = descend_from(fit, options.other_knots_s, options.ringing, step_s);
  return other && (!found || rows.criterion(other->best) < rows.criterion(found->best)) ? other : found;
}

/// The best fit with one knot more, between two knots or one split into two.
Descent with_knot_more(const SpeedProfileFit& fit, const Vector& best) {
  const std::size_t knots = best.size() - 3;
  SpeedProfileFit more = fit;
  more.set_knots(knots + 1);
  Descent found;
  const auto try_with = [&](Vector parameters) {
    const double cost = more.descend(parameters, 4);
    if (cost < found.cost) found = {cost, std::move(parameters)};
  };
  for (std::size_t k = 0; k + 1 < knots; ++k) {
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
  if (found.cost < infinite) found.cost = more.descend(found.parameters, 40);
  return found;
}

void add_knots(SpeedProfileFit& fit, Descent& best, const Rows& rows, std::size_t most_knots) {
  constexpr double least_gain = 10.0;
  for (std::size_t knots = best.parameters.size() - 3; knots < most_knots && rows.times.size() > 2 * (knots + 1); ++knots) {
    if (fit.misfit_at(best.parameters) <= well_fitted) return;
    Descent more = with_knot_more(fit, best.parameters);
    if (!(more.cost < infinite) || rows.criterion(more) > rows.criterion(best) - least_gain) return;
    fit.set_knots(knots + 1);
    best = std::move(more);
    best.cost = fit.descend(best.parameters, 1);
  }
}

/// Makes one of two close knots where that fits better.
void merge_close_knots(SpeedProfileFit& fit, Descent& best, const Rows& rows) {
  const double close_s = close_steps * usual_step_s(rows.times);
  for (std::size_t k = 0; best.parameters.size() - 3 > 3 && k + 1 < best.parameters.size() - 3;) {
    const std::size_t knots = best.parameters.size() - 3;
    const Vector& at = best.parameters;
    if (at[k + 1] - at[k] >= close_s) {
      ++k;
      continue;
    }
    SpeedProfileFit fewer = fit;
    fewer.set_knots(knots - 1);
    Descent merged{.cost = infinite, .parameters = at};
    const bool is_last = k + 2 == knots;
    if (k > 0 && !is_last) merged.parameters[k] = 0.5 * (at[k] + at[k + 1]);
    merged.parameters.erase(merged.parameters.begin() + static_cast<std::ptrdiff_t>(is_last ? k : k + 1));
    merged.cost = fewer.descend(merged.parameters, 40);
    if (!(rows.criterion(merged) < rows.criterion(best))) {
      ++k;
      continue;
    }
    fit.set_knots(knots - 1);
    best = std::move(merged);
    best.cost = fit.descend(best.parameters, 1);
    k = 0;
  }
}

/// Rivals that fit nearly as well show where else a knot may be: their spread, weighted by likelihood, widens its variance.
void add_rivals(SpeedProfile& profile, const std::vector<Descent>& rivals, double misfit) {
  const std::size_t knots = profile.knots_s.size();
  double least = infinite, all = 0;
  const auto has_same_knots = [&](const Descent& rival) { return rival.parameters.size() == knots + 3; };
  for (const Descent& rival : rivals) {
    if (has_same_knots(rival)) least = std::min(least, rival.cost);
  }
  for (const Descent& rival : rivals) all += has_same_knots(rival) ? std::exp(-0.5 * (rival.cost - least) / misfit) : 0.0;
  for (const Descent& rival : rivals) {
    if (!has_same_knots(rival)) continue;
    const double share = std::exp(-0.5 * (rival.cost - least) / misfit) / all;
    for (std::size_t k = 0; k < knots; ++k) {
      const double off = rival.parameters[k] - profile.knots_s[k];
      profile.covariance[k * knots + k] += share * off * off;
    }
  }
}

std::optional<SpeedProfile> profile_of(SpeedProfileFit& fit, const Descent& best, const std::vector<Descent>& rivals,
                                       const Rows& rows, const SpeedProfileOptions& options) {
  const std::size_t knots = best.parameters.size() - 3;
  SpeedProfile profile;
  profile.knots_s.assign(best.parameters.begin(), best.parameters.end() - 3);
  profile.open_begin = options.open_begin;
  profile.open_end = options.open_end;
  profile.ringing = fit.ringing_of(best.parameters);
  profile.covariance = fit.covariance_at(best.parameters);
  if (profile.covariance.empty()) return std::nullopt;
  const double misfit = fit.misfit(), factor = std::max(1.0, misfit) * fit.correlation_factor();
  for (double& value : profile.covariance) value *= factor;
  add_rivals(profile, rivals, std::max(1.0, misfit));
  profile.speed_sigma = options.noise * std::sqrt(misfit);
  for (std::size_t k = 0; k < knots; ++k) {
    Speed speed{};
    for (std::size_t a = 0; a < 3; ++a) speed[a] = rows.axis ? fit.speed(k, 0) * (*rows.axis)[a] : fit.speed(k, a);
    profile.speeds.push_back(speed);
  }
  return profile;
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

Vector3 SpeedProfile::change_at(std::size_t k) const {
  Vector3 change{};
  if ((k == 0 && open_begin) || (k + 1 == knots_s.size() && open_end)) return change;
  for (std::size_t a = 0; a < 3; ++a) {
    if (k > 0) change[a] -= (speeds[k][a] - speeds[k - 1][a]) / (knots_s[k] - knots_s[k - 1]);
    if (k + 1 < knots_s.size()) change[a] += (speeds[k + 1][a] - speeds[k][a]) / (knots_s[k + 1] - knots_s[k]);
  }
  return change;
}

Speed SpeedProfile::ringing_at(double t_s) const {
  Speed speed{};
  const double w = 2.0 * std::numbers::pi * ringing.hz;
  for (std::size_t k = 0; k < knots_s.size(); ++k) {
    const double since_s = t_s - knots_s[k];
    if (since_s <= 0 || since_s > faded * ringing.decay_s) continue;
    const double swing = -ringing.share * std::exp(-since_s / ringing.decay_s) * std::sin(w * since_s) / w;
    const Vector3 change = change_at(k);
    for (std::size_t a = 0; a < 3; ++a) speed[a] += change[a] * swing;
  }
  return speed;
}

double SpeedProfile::speed_m_s(double t_s) const {
  const Speed commanded = commanded_at(t_s), ringing_speed = ringing_at(t_s);
  return length_of({commanded[0] + ringing_speed[0], commanded[1] + ringing_speed[1], commanded[2] + ringing_speed[2]});
}

double SpeedProfile::sigma_s(std::size_t knot) const { return std::sqrt(covariance[knot * knots_s.size() + knot]); }

bool SpeedProfile::rings() const {
  double greatest = 0;
  for (std::size_t k = 0; k < knots_s.size(); ++k) greatest = std::max(greatest, length_of(change_at(k)));
  constexpr double stands_out = 3.0;
  return ringing.share * greatest > stands_out * 2.0 * std::numbers::pi * ringing.hz * speed_sigma;
}

void SpeedProfile::append(const SpeedProfile& later) {
  knots_s.insert(knots_s.end(), later.knots_s.begin(), later.knots_s.end());
  speeds.insert(speeds.end(), later.speeds.begin(), later.speeds.end());
  open_end = later.open_end;
  covariance.clear();  // the two fits know nothing of each other
  speed_sigma = std::max(speed_sigma, later.speed_sigma);
}

std::optional<SpeedProfile> fit_speed_profile(std::span<const SpeedRow> speed_rows, const SpeedProfileOptions& options) {
  assert(options.knots_s.size() >= 3 && "a motion has a start, a middle and an end");
  if (speed_rows.size() < options.knots_s.size() + 6) return std::nullopt;
  const Rows rows(speed_rows, options.noise);
  SpeedProfileFit fit(rows.times, rows.values, options);
  std::optional<Descents> descents = first_descent(fit, rows, options);
  if (!descents) return std::nullopt;
  Descent& best = descents->best;
  fit.set_knots(best.parameters.size() - 3);
  if (fit.misfit_at(best.parameters) > well_fitted) {  // perhaps because of single rows
    fit.weigh_rows();
    best.cost = fit.descend(best.parameters, 20);
  }
  add_knots(fit, best, rows, options.most_knots);
  merge_close_knots(fit, best, rows);
  for (int round = 0; round < 2; ++round) {
    fit.weigh_rows();
    best.cost = fit.descend(best.parameters, 20);
  }
  return profile_of(fit, best, descents->rivals, rows, options);
}

}  // namespace tactile::alignment
