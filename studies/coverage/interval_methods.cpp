#include "interval_methods.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <numeric>
#include <set>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::study {
namespace {

using evaluation::CrossedCell;
using evaluation::CrossedResults;
using evaluation::RunsByObject;

bool of_one_object(const Trial& trial) { return trial.objects.size() == 1; }

double share_outside(const results::BootstrapOptions& options) { return (1 - options.confidence) / 2; }

Bounds chosen(const Trial& trial, const results::BootstrapOptions& options) {
  const auto figure = of_one_object(trial)
                          ? evaluation::figure_of_object(trial.objects.front(), trial.statistic, options, trial.range)
                          : evaluation::figure_over_objects(trial.objects, trial.statistic, options, trial.range);
  return bounds_of(figure);
}

/// The same with all of the misses for Student's distribution.
Bounds chosen_without_reserve(const Trial& trial, const results::BootstrapOptions& given) {
  results::BootstrapOptions options = given;
  options.confidence = 1 - (1 - options.confidence) / 0.5;
  return chosen(trial, options);
}

std::size_t trainings_of(const Trial& trial) {
  std::set<std::size_t> trainings;
  for (const auto& object : trial.objects) {
    for (const CrossedCell& cell : object) trainings.insert(cell.training);
  }
  return trainings.size();
}

/// The cells of each run of each object.
std::vector<std::vector<std::vector<CrossedCell>>> by_run(const CrossedResults& objects) {
  std::vector<std::vector<std::vector<CrossedCell>>> result;
  for (const auto& object : objects) {
    std::map<std::size_t, std::vector<CrossedCell>> runs;
    for (const CrossedCell& cell : object) runs[cell.run].push_back(cell);
    result.emplace_back();
    for (const auto& [run, cells] : runs) result.back().push_back(cells);
  }
  return result;
}

/// Values of the figure, with objects drawn, runs within them, and trainings if `with_trainings`.
std::vector<double> drawn_values(const Trial& trial, const results::BootstrapOptions& options, bool with_trainings) {
  const auto objects = by_run(trial.objects);
  const std::size_t trainings = trainings_of(trial);
  Random random(options.seed);
  std::vector<double> values;
  for (std::size_t i = 0; i < options.draws; ++i) {
    std::vector<std::size_t> times(trainings, with_trainings ? 0 : 1);
    for (std::size_t k = 0; k < trainings && with_trainings; ++k) ++times[random.below(trainings)];
    RunsByObject lists;
    for (std::size_t o = 0; o < objects.size(); ++o) {
      const auto& runs = objects[random.below(objects.size())];
      std::vector<std::size_t> list;
      for (std::size_t r = 0; r < runs.size(); ++r) {
        for (const CrossedCell& cell : runs[random.below(runs.size())]) list.insert(list.end(), times[cell.training], cell.index);
      }
      if (!list.empty()) lists.push_back(std::move(list));
    }
    if (lists.empty()) continue;
    if (const auto value = trial.statistic(lists)) values.push_back(*value);
  }
  return values;
}

Bounds middle_of(const std::vector<double>& values, double low, double high) {
  if (values.empty()) return std::nullopt;
  return std::pair{quantile(values, low), quantile(values, high)};
}

Bounds percentile_without_trainings(const Trial& trial, const results::BootstrapOptions& options) {
  return middle_of(drawn_values(trial, options, false), share_outside(options), 1 - share_outside(options));
}

Bounds percentile(const Trial& trial, const results::BootstrapOptions& options) {
  return middle_of(drawn_values(trial, options, true), share_outside(options), 1 - share_outside(options));
}

/// The figure without those cells for which `left_out` is true.
template <class LeftOut>
std::optional<double> value_without(const Trial& trial, LeftOut left_out) {
  RunsByObject lists;
  for (std::size_t object = 0; object < trial.objects.size(); ++object) {
    std::vector<std::size_t> list;
    for (const CrossedCell& cell : trial.objects[object]) {
      if (!left_out(object, cell)) list.push_back(cell.index);
    }
    if (!list.empty()) lists.push_back(std::move(list));
  }
  return lists.empty() ? std::nullopt : trial.statistic(lists);
}

struct Without {
  double value = 0;
  std::vector<double> units, trainings;  // the figure without each run or object, and without each training
};

Without without_each(const Trial& trial) {
  Without without{value_without(trial, [](std::size_t, const CrossedCell&) { return false; }).value(), {}, {}};
  std::set<std::size_t> units;
  for (std::size_t object = 0; object < trial.objects.size(); ++object) {
    for (const CrossedCell& cell : trial.objects[object]) units.insert(of_one_object(trial) ? cell.run : object);
  }
  for (const std::size_t unit : units) {
    const auto value = value_without(
        trial, [&](std::size_t object, const CrossedCell& cell) { return (of_one_object(trial) ? cell.run : object) == unit; });
    if (value) without.units.push_back(*value);
  }
  const std::size_t count = trainings_of(trial);
  for (std::size_t training = 0; training < count && count > 1; ++training) {
    const auto value = value_without(trial, [&](std::size_t, const CrossedCell& cell) { return cell.training == training; });
    if (value) without.trainings.push_back(*value);
  }
  return without;
}

/// Jackknife influences: (n - 1) (mean - value without). Their variance over n is that of the figure.
std::vector<double> influences(std::vector<double> without) {
  if (without.empty()) return {};
  const auto n = static_cast<double>(without.size());
  const double mean = std::accumulate(without.begin(), without.end(), 0.0) / n;
  for (double& value : without) value = (n - 1) * (mean - value);
  return without;
}

double variance_of_mean(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum / (n - 1) / n;
}

double normal_probability(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

double normal_quantile(double p) {
  double low = -10, high = 10;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (normal_probability(middle) < p ? low : high) = middle;
  }
  return low;
}

Bounds bias_corrected(const Trial& trial, const results::BootstrapOptions& options) {
  const std::vector<double> values = drawn_values(trial, options, true);
  if (values.empty()) return std::nullopt;
  const Without without = without_each(trial);
  double below = 0;
  for (const double value : values) below += value < without.value ? 1 : value == without.value ? 0.5 : 0;
  const auto count = static_cast<double>(values.size());
  const double bias = normal_quantile(std::clamp(below / count, 0.5 / count, 1 - 0.5 / count));
  double squares = 0, cubes = 0;
  for (const auto& list : {influences(without.units), influences(without.trainings)}) {
    for (const double x : list) {
      const double scaled = x / static_cast<double>(list.size());
      squares += scaled * scaled;
      cubes += scaled * scaled * scaled;
    }
  }
  const double acceleration = squares > 0 ? cubes / (6 * std::pow(squares, 1.5)) : 0;
  const auto place = [&](double p) {
    const double z = bias + normal_quantile(p);
    return normal_probability(bias + z / std::max(1 - acceleration * z, 1e-3));
  };
  return middle_of(values, place(share_outside(options)), place(1 - share_outside(options)));
}

double on_scale(const evaluation::Range& range, double x) {
  double result = std::isfinite(range.lowest) || std::isfinite(range.highest) ? 0 : x;
  if (std::isfinite(range.lowest)) result += std::log(x - range.lowest);
  if (std::isfinite(range.highest)) result -= std::log(range.highest - x);
  return result;
}

double gradient_of(const evaluation::Range& range, double x) {
  if (!std::isfinite(range.lowest) && !std::isfinite(range.highest)) return 1;
  return (std::isfinite(range.lowest) ? 1 / (x - range.lowest) : 0) +
         (std::isfinite(range.highest) ? 1 / (range.highest - x) : 0);
}

double from_scale(const evaluation::Range& range, double s) {
  if (std::isfinite(range.highest)) return range.lowest + (range.highest - range.lowest) / (1 + std::exp(-s));
  return std::isfinite(range.lowest) ? range.lowest + std::exp(s) : s;
}

/// Bootstrap-t: influences are drawn, and each draw is divided by its own standard error, on the scale of the range.
Bounds studentised(const Trial& trial, const results::BootstrapOptions& options) {
  const Without without = without_each(trial);
  const std::vector<std::vector<double>> lists{influences(without.units), influences(without.trainings)};
  const double variance = variance_of_mean(lists[0]) + variance_of_mean(lists[1]);
  if (!(variance > 0) || without.value <= trial.range.lowest || without.value >= trial.range.highest) return std::nullopt;
  Random random(options.seed);
  std::vector<double> values;
  for (std::size_t i = 0; i < options.draws; ++i) {
    double value = without.value, of_draw = 0;
    for (const auto& list : lists) {
      if (list.empty()) continue;
      std::vector<double> drawn(list.size());
      for (double& x : drawn) x = list[random.below(list.size())];
      value += std::accumulate(drawn.begin(), drawn.end(), 0.0) / static_cast<double>(drawn.size());
      of_draw += variance_of_mean(drawn);
    }
    if (of_draw <= 0 || value <= trial.range.lowest || value >= trial.range.highest) continue;
    values.push_back((on_scale(trial.range, value) - on_scale(trial.range, without.value)) /
                     (std::sqrt(of_draw) * gradient_of(trial.range, value)));
  }
  if (2 * values.size() < options.draws) return std::nullopt;
  const double error = std::sqrt(variance) * gradient_of(trial.range, without.value), s = on_scale(trial.range, without.value);
  return std::pair{from_scale(trial.range, s - quantile(values, 1 - share_outside(options)) * error),
                   from_scale(trial.range, s - quantile(values, share_outside(options)) * error)};
}

/// Student's quantile for any number of degrees of freedom from 1, by integration of cos^(d - 1).
double any_student_quantile(double freedom, double confidence) {
  static std::map<std::pair<long, double>, double> known;
  static std::mutex mutex;
  freedom = std::min(freedom, 200.0);
  const std::pair key{std::lround(freedom * 50), confidence};
  const std::scoped_lock lock(mutex);
  if (const auto found = known.find(key); found != known.end()) return found->second;
  constexpr int steps = 20000;
  std::vector<double> sums{0};
  for (int i = 0; i < steps; ++i)
    sums.push_back(sums.back() +
                   std::pow(std::cos(std::acos(-1.0) / 2 * (i + 0.5) / steps), static_cast<double>(key.first) / 50 - 1));
  const auto found = std::lower_bound(sums.begin(), sums.end(), confidence * sums.back());
  const double angle = std::acos(-1.0) / 2 * static_cast<double>(found - sums.begin()) / steps;
  return known[key] = std::sqrt(freedom) * std::tan(angle);
}

/// Student's interval: variances of units and trainings by the jackknife, degrees of freedom by Satterthwaite.
Bounds hierarchical(const Trial& trial, const results::BootstrapOptions& options, const evaluation::Range& range) {
  const Without without = without_each(trial);
  if (without.value <= range.lowest || without.value >= range.highest || without.units.size() < 3) return std::nullopt;
  const double units = variance_of_mean(influences(without.units)), trainings = variance_of_mean(influences(without.trainings));
  const double variance = units + trainings;
  if (!(variance > 0)) return std::nullopt;
  double below = units * units / static_cast<double>(without.units.size() - 1);
  if (without.trainings.size() > 1) below += trainings * trainings / static_cast<double>(without.trainings.size() - 1);
  const double half = any_student_quantile(variance * variance / below, options.confidence) * std::sqrt(variance) *
                      gradient_of(range, without.value);
  const double s = on_scale(range, without.value);
  return std::pair{from_scale(range, s - half), from_scale(range, s + half)};
}

Bounds hierarchical_plain(const Trial& trial, const results::BootstrapOptions& options) {
  return hierarchical(trial, options, {});
}

Bounds hierarchical_scaled(const Trial& trial, const results::BootstrapOptions& options) {
  return hierarchical(trial, options, trial.range);
}

double digamma(double x) {
  double shift = 0;
  while (x < 10) {
    shift += 1 / x;
    x += 1;
  }
  const double y = 1 / (x * x);
  return std::log(x) - 0.5 / x - y * (1.0 / 12 - y * (1.0 / 120 - y / 252)) - shift;
}

double trigamma(double x) {
  double shift = 0;
  while (x < 10) {
    shift += 1 / (x * x);
    x += 1;
  }
  const double y = 1 / (x * x);
  return shift + 1 / x + y / 2 + y / x * (1.0 / 6 - y * (1.0 / 30 - y / 42));
}

/// A variance with its degrees of freedom.
struct FreeVariance {
  double value = 0, freedom = 0;

  FreeVariance with(const FreeVariance& prior) const {
    return {(prior.freedom * prior.value + freedom * value) / (prior.freedom + freedom), prior.freedom + freedom};
  }
  double square(double confidence) const {
    const double t = any_student_quantile(freedom, confidence);
    return t * t * value;
  }
};

/// What the variances have in common; nothing, of no degrees of freedom, where fewer than three are above 0.
FreeVariance prior_of(const std::vector<FreeVariance>& variances) {
  std::vector<double> positive, logs;
  for (const FreeVariance& variance : variances) {
    if (variance.value > 0) positive.push_back(variance.value);
  }
  if (positive.size() < 3) return {};
  const double least = 1e-5 * median(positive), d = variances.front().freedom;
  double sum = 0, together = 0;
  for (const FreeVariance& variance : variances) {
    logs.push_back(std::log(std::max(variance.value, least)) - digamma(d / 2) + std::log(d / 2));
    sum += variance.value;
    together += variance.freedom;
  }
  const auto n = static_cast<double>(logs.size());
  const double spread = n * variance_of_mean(logs) - trigamma(d / 2), mean = std::accumulate(logs.begin(), logs.end(), 0.0) / n;
  if (spread <= 0) return {sum / n, together - d};
  double low = 1e-3, high = 1e4;  // of half of the degrees of freedom
  for (int step = 0; step < 60; ++step) {
    const double middle = std::sqrt(low * high);
    (trigamma(middle) > spread ? low : high) = middle;
  }
  return {std::exp(mean + digamma(low) - std::log(low)), std::min(2 * low, together - d)};
}

/// The variance that runs and trainings have in common, on the scale: from the values without each pair of them.
double variance_of_pairs(const Trial& object, const std::function<double(double)>& scale) {
  std::set<std::size_t> runs;
  for (const CrossedCell& cell : object.objects.front()) runs.insert(cell.run);
  const std::size_t trainings = trainings_of(object);
  std::vector<std::vector<double>> rows;
  for (const std::size_t run : runs) {
    rows.emplace_back();
    for (std::size_t training = 0; training < trainings; ++training) {
      const auto value = value_without(
          object, [&](std::size_t, const CrossedCell& cell) { return cell.run == run || cell.training == training; });
      if (!value) return 0;
      rows.back().push_back(scale(*value));
    }
  }
  const auto n = static_cast<double>(rows.size()), k = static_cast<double>(trainings);
  std::vector<double> of_training(trainings);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < trainings; ++i) of_training[i] += row[i] / n;
  }
  const double mean = std::accumulate(of_training.begin(), of_training.end(), 0.0) / k;
  double sum = 0;
  for (const auto& row : rows) {
    const double of_run = std::accumulate(row.begin(), row.end(), 0.0) / k;
    for (std::size_t i = 0; i < trainings; ++i) sum += std::pow(row[i] - of_run - of_training[i] + mean, 2);
  }
  return sum * (n - 1) * (k - 1) / (n * k);
}

/// The variances of one object's figure on the scale.
struct ObjectVariances {
  double value = 0, pairs = 0;
  FreeVariance runs, trainings;
};

std::optional<ObjectVariances> variances_of(const Trial& object) {
  const Without without = without_each(object);
  const evaluation::Range& range = object.range;
  if (without.value <= range.lowest || without.value >= range.highest || without.units.size() < 3) return std::nullopt;
  // Without a run the figure may be at a limit: it counts as the n-th part of the value's distance.
  const auto scaled = [&](double x, std::size_t n) {
    const double part = 1 / static_cast<double>(n);
    if (std::isfinite(range.lowest)) x = std::max(x, range.lowest + part * (without.value - range.lowest));
    if (std::isfinite(range.highest)) x = std::min(x, range.highest - part * (range.highest - without.value));
    return on_scale(range, x);
  };
  const auto variance_by = [&](std::vector<double> values) {
    for (double& x : values) x = scaled(x, values.size());
    return FreeVariance{variance_of_mean(influences(values)), static_cast<double>(values.size()) - 1};
  };
  const std::size_t pairs = without.units.size() * without.trainings.size();
  return ObjectVariances{without.value, variance_of_pairs(object, [&](double x) { return scaled(x, pairs); }),
                         variance_by(without.units), variance_by(without.trainings)};
}

}  // namespace

Bounds bounds_of(const results::Figure& figure) {
  if (!figure.has_interval()) return std::nullopt;
  return std::pair{*figure.low, *figure.high};
}

std::vector<Bounds> moderated_bounds(const Trial& trial, const results::BootstrapOptions& options) {
  std::vector<std::optional<ObjectVariances>> objects;
  std::vector<FreeVariance> runs, trainings;
  for (const auto& cells : trial.objects) {
    objects.push_back(variances_of({{cells}, trial.statistic, trial.range}));
    if (!objects.back()) continue;
    runs.push_back(objects.back()->runs);
    trainings.push_back(objects.back()->trainings);
  }
  const FreeVariance of_runs = prior_of(runs), of_trainings = prior_of(trainings);
  const double confidence = 1 - 0.7 * (1 - options.confidence);
  std::vector<Bounds> bounds;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    double square = 0;
    if (objects[i]) {
      FreeVariance by_training = objects[i]->trainings.with(of_trainings);
      by_training.value = std::max(0.0, by_training.value - objects[i]->pairs);
      square = objects[i]->runs.with(of_runs).square(confidence) + by_training.square(confidence);
    }
    const double s = square > 0 ? on_scale(trial.range, objects[i]->value) : 0, half = std::sqrt(square);
    bounds.push_back(square > 0 ? Bounds({from_scale(trial.range, s - half), from_scale(trial.range, s + half)})
                                : chosen({{trial.objects[i]}, trial.statistic, trial.range}, options));
  }
  return bounds;
}

const std::vector<IntervalMethod>& interval_methods() {
  static const std::vector<IntervalMethod> methods{
      {"the one in use", chosen},
      {"the same without its reserve", chosen_without_reserve},
      {"percentile, objects and runs", percentile_without_trainings},
      {"percentile, trainings too", percentile},
      {"BCa", bias_corrected},
      {"bootstrap-t on the scale", studentised},
      {"t, Satterthwaite", hierarchical_plain},
      {"t, Satterthwaite, on the scale", hierarchical_scaled},
  };
  return methods;
}

}  // namespace tactile::study
