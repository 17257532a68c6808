#include "tactile/evaluation/crossed_figure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>

#include "tactile/core/random.hpp"

namespace tactile::evaluation {
namespace {

constexpr std::size_t fewest_units = 3;
constexpr double unlimited = 1000;  // times its value, a figure without an upper limit counts as a share of this
// Of the misses that are allowed, the share that Student's distribution gets. The rest is for what is not normal. Chosen by the
// study of docs/numerics/.
constexpr double share_of_misses = 0.5;
constexpr double rough = 1.1 * 1.1;  // the variance of draws, over that of the jackknife, from which on the draws count

enum Level : std::size_t { by_training, by_object, by_run };
using TimesTaken = std::array<std::vector<unsigned>, 3>;  // how often each training, object and run is taken

/// The cells of all objects, with trainings and runs counted from 0, runs across objects.
class Crossing {
 public:
  Crossing(const CrossedResults& results, const Statistic& statistic) : statistic_(statistic) {
    std::map<std::size_t, std::size_t> training_of;
    for (const CrossedObject& object : results) {
      for (const CrossedCell& cell : object) training_of.emplace(cell.training, 0);
    }
    std::size_t count = 0, first_run = 0;
    for (auto& [id, number] : training_of) number = count++;
    for (const CrossedObject& object : results) {
      if (object.empty()) continue;
      std::map<std::size_t, std::size_t> run_of;
      for (const CrossedCell& cell : object) run_of.emplace(cell.run, 0);
      count = first_run;
      for (auto& [id, number] : run_of) number = count++;
      runs_of_objects_.push_back({first_run, count});
      first_run = count;
      objects_.emplace_back();
      for (const CrossedCell& cell : object)
        objects_.back().push_back({training_of.at(cell.training), run_of.at(cell.run), cell.index});
    }
    all_ = {std::vector<unsigned>(training_of.size(), 1), std::vector<unsigned>(objects_.size(), 1),
            std::vector<unsigned>(first_run, 1)};
  }

  std::size_t count(Level level) const { return all_[level].size(); }
  const TimesTaken& all() const { return all_; }

  std::optional<double> value(const TimesTaken& weights) {
    lists_.clear();
    for (std::size_t object = 0; object < objects_.size(); ++object) {
      if (weights[by_object][object] == 0) continue;
      list_.clear();
      for (const CrossedCell& cell : objects_[object])
        list_.insert(list_.end(), std::size_t{weights[by_training][cell.training]} * weights[by_run][cell.run], cell.index);
      if (!list_.empty()) lists_.insert(lists_.end(), weights[by_object][object], list_);
    }
    if (lists_.empty()) return std::nullopt;
    const auto value = statistic_(lists_);
    return value && std::isfinite(*value) ? value : std::nullopt;
  }

  std::size_t smallest_group(Level level) const {
    std::size_t smallest = count(level);
    for (const auto& [first, last] : groups(level)) smallest = std::min(smallest, last - first);
    return smallest;
  }

  /// Groups of numbers of a level, of which as many are drawn as there are: all trainings, all objects, the runs of each object.
  std::vector<std::pair<std::size_t, std::size_t>> groups(Level level) const {
    if (level == by_run) return runs_of_objects_;
    return {{0, count(level)}};
  }

 private:
  const Statistic& statistic_;
  CrossedResults objects_;
  std::vector<std::pair<std::size_t, std::size_t>> runs_of_objects_;  // first, and one past the last
  TimesTaken all_;
  RunsByObject lists_;
  std::vector<std::size_t> list_;
};

double sum_of_squares(std::span<const double> values) {
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum;
}

/// (n - 1) / n sum of (value - mean)^2 of what a figure is without each training, object or run.
double jackknife_variance(std::span<const double> without) {
  const auto n = static_cast<double>(without.size());
  return without.size() < 2 ? 0 : (n - 1) / n * sum_of_squares(without);
}

std::vector<double> deletions(Crossing& crossing, Level level, std::pair<std::size_t, std::size_t> group) {
  std::vector<double> values;
  TimesTaken weights = crossing.all();
  for (std::size_t i = group.first; i < group.second; ++i) {
    weights[level][i] = 0;
    if (const auto value = crossing.value(weights)) values.push_back(*value);
    weights[level][i] = 1;
  }
  return values;
}

/// The variance of draws with replacement, times n / (n - 1); nothing where more than half of the draws give nothing.
std::optional<double> variance_of_draws(Crossing& crossing, Level level, std::size_t draws, std::uint64_t seed) {
  constexpr std::array<std::string_view, 3> names{"trainings", "objects", "runs"};
  Random random(seed_for(seed, {"bootstrap", names[level]}));
  TimesTaken weights = crossing.all();
  const auto groups = crossing.groups(level);
  double drawn_from = 0, free = 0;
  for (const auto& [first, last] : groups) {
    drawn_from += static_cast<double>(last - first);
    free += static_cast<double>(last - first - 1);
  }
  if (free <= 0) return 0;
  std::vector<double> values;
  for (std::size_t i = 0; i < draws; ++i) {
    std::fill(weights[level].begin(), weights[level].end(), 0U);
    for (const auto& [first, last] : groups) {
      for (std::size_t drawn = first; drawn < last; ++drawn) ++weights[level][first + random.below(last - first)];
    }
    if (const auto value = crossing.value(weights)) values.push_back(*value);
  }
  if (2 * values.size() < draws || values.size() < 2) return std::nullopt;
  return sum_of_squares(values) / static_cast<double>(values.size() - 1) * drawn_from / free;
}

struct Variance {
  double value = 0;
  bool rough = false;  // it comes from draws
  std::size_t freedom = 1;
};

std::optional<Variance> variance_over(Crossing& crossing, Level level, const results::BootstrapOptions& options) {
  if (crossing.count(level) < 2) return Variance{};
  double sum = 0, squares = 0;
  const std::size_t fewest = crossing.smallest_group(level) - 1;
  for (const auto& group : crossing.groups(level)) {
    const double of_group = jackknife_variance(deletions(crossing, level, group));
    sum += of_group;
    squares += of_group * of_group / static_cast<double>(group.second - group.first - 1);
  }
  const std::size_t freedom = squares > 0 ? std::max(fewest, static_cast<std::size_t>(sum * sum / squares * (1 + 1e-9))) : fewest;
  const auto drawn = variance_of_draws(crossing, level, (options.draws + 1) / 2, options.seed);
  if (!drawn) return std::nullopt;
  const bool is_rough = *drawn > rough * sum;
  return Variance{is_rough ? *drawn : sum, is_rough, freedom};
}

/// The part of both variances that comes from single results: from the figure without each pair of a training and one of a group.
double variance_of_both(Crossing& crossing, Level level, std::pair<std::size_t, std::size_t> group) {
  const std::size_t rows = group.second - group.first, columns = crossing.count(by_training);
  std::vector<double> of_row(rows), of_column(columns), table(rows * columns);
  const auto n_rows = static_cast<double>(rows), n_columns = static_cast<double>(columns);
  TimesTaken weights = crossing.all();
  for (std::size_t row = 0; row < rows; ++row) {
    weights[level][group.first + row] = 0;
    for (std::size_t column = 0; column < columns; ++column) {
      weights[by_training][column] = 0;
      const auto value = crossing.value(weights);
      weights[by_training][column] = 1;
      if (!value) return 0;
      const double x = table[row * columns + column] = *value;
      of_row[row] += x / n_columns;
      of_column[column] += x / n_rows;
    }
    weights[level][group.first + row] = 1;
  }
  const double mean = std::accumulate(of_row.begin(), of_row.end(), 0.0) / n_rows;
  double sum = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const double rest = table[row * columns + column] - of_row[row] - of_column[column] + mean;
      sum += rest * rest;
    }
  }
  return sum * (n_rows - 1) * (n_columns - 1) / (n_rows * n_columns);
}

double variance_of_both(Crossing& crossing, Level level) {
  double sum = 0;
  for (const auto& group : crossing.groups(level)) sum += variance_of_both(crossing, level, group);
  return sum;
}

/// The normal distribution is at most this far from its mean with the probability `confidence`.
double normal_quantile(double confidence) {
  double low = 0, high = 40;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (std::erf(middle / std::numbers::sqrt2) < confidence ? low : high) = middle;
  }
  return high;
}

/// @param square  of half the interval of a normal figure
/// @param least   what one event changes; 0: not known
void set_bounds(results::Figure& figure, double square, double least, const Range& range, double confidence) {
  const double value = figure.value;
  // Sums of the same numbers in another order differ in their last bits.
  const bool varies = std::sqrt(square) > 1e-12 * std::abs(value) + 1e-300;
  if (!varies && !(least > 0)) return;
  const double half = varies ? std::sqrt(square) : least * poisson_upper_bound(0, confidence);
  const double highest =
      std::isfinite(range.highest) ? range.highest : range.lowest + unlimited * std::max(value - range.lowest, least);
  const double width = highest - range.lowest, share = (value - range.lowest) / width;
  const bool is_at_limit = std::abs(std::min(share, 1 - share)) < 1e-12;
  double low = value - half, high = value + half;
  if (std::isfinite(width) && (is_at_limit ? !varies : share > 0 && share < 1)) {
    const double z_width = normal_quantile(confidence) * width;
    const double trials = is_at_limit ? width / least : share * (1 - share) * z_width * z_width / (half * half);
    std::tie(low, high) = binomial_bounds((is_at_limit ? std::round(share) : share) * trials, trials, confidence);
    low = range.lowest + width * low;
    high = range.lowest + width * high;
  }
  figure.low = std::min(value, std::max(low, range.lowest));
  figure.high = std::max(value, std::min(high, range.highest));
}

results::Figure figure_of(Crossing& crossing, Level level, const results::BootstrapOptions& options, const Range& range) {
  results::Figure figure;
  figure.n = crossing.count(level);
  if (figure.n == 0) return figure;
  figure.trainings = crossing.count(by_training);
  const auto value = crossing.value(crossing.all());
  if (value) figure.value = *value;
  const std::size_t count = crossing.count(by_training);
  if (!value || !allows_bounds(crossing.smallest_group(level), count)) return figure;
  const auto of_units = variance_over(crossing, level, options);
  const auto of_trainings = variance_over(crossing, by_training, options);
  if (!of_units || !of_trainings) return figure;
  const double confidence = 1 - share_of_misses * (1 - options.confidence);
  const double t_units = student_quantile(of_units->freedom, confidence);
  double square = t_units * t_units * of_units->value;
  if (count > 1) {
    const double both = of_units->rough || of_trainings->rough ? 0 : variance_of_both(crossing, level);
    const double t = student_quantile(count - 1, confidence);
    square += t * t * std::max(0.0, of_trainings->value - both);
  }
  set_bounds(figure, square, range.step / static_cast<double>(crossing.count(by_run)), range, options.confidence);
  return figure;
}

}  // namespace

bool allows_bounds(std::size_t units, std::size_t trainings) {
  return units >= fewest_units && (trainings <= 1 || trainings >= fewest_units);
}

results::Figure figure_of_object(const CrossedObject& cells, const Statistic& statistic, const results::BootstrapOptions& options,
                                 const Range& range) {
  return figure_of_these_objects({cells}, statistic, options, range);
}

results::Figure figure_of_these_objects(const CrossedResults& objects, const Statistic& statistic,
                                        const results::BootstrapOptions& options, const Range& range) {
  Crossing crossing(objects, statistic);
  return figure_of(crossing, by_run, options, range);
}

results::Figure figure_over_objects(const CrossedResults& results, const Statistic& statistic,
                                    const results::BootstrapOptions& options, const Range& range) {
  Crossing crossing(results, statistic);
  return figure_of(crossing, by_object, options, range);
}

CrossedResults without_names(const std::map<std::string, CrossedObject>& objects) {
  CrossedResults results;
  for (const auto& object : objects) results.push_back(object.second);
  return results;
}

unsigned most_results_of_a_run(const CrossedResults& objects) {
  unsigned most = 1;
  for (const CrossedObject& cells : objects) {
    std::map<std::size_t, unsigned> count;
    for (const CrossedCell& cell : cells) most = std::max(most, ++count[cell.run]);
  }
  return most;
}

std::size_t result_count(const CrossedResults& objects) {
  std::size_t count = 0;
  for (const CrossedObject& cells : objects) count += cells.size();
  return count;
}

std::vector<std::size_t> indexes_of(const CrossedObject& cells) {
  std::vector<std::size_t> indexes;
  for (const CrossedCell& cell : cells) indexes.push_back(cell.index);
  return indexes;
}

RunsByObject all_of(const CrossedResults& objects) {
  RunsByObject all;
  for (const CrossedObject& cells : objects) all.push_back(indexes_of(cells));
  return all;
}

double student_quantile(std::size_t freedom, double confidence) {
  // The probability of |t| <= sqrt(freedom) tan(angle) is a finite sum of powers of the angle's cosine.
  const auto probability = [freedom](double angle) {
    const double sine = std::sin(angle), cosine = std::cos(angle);
    const bool odd = freedom % 2 == 1;
    double term = odd ? cosine : 1, sum = 0;
    for (std::size_t power = odd ? 3 : 2; power <= freedom; power += 2) {
      sum += term;
      term *= cosine * cosine * static_cast<double>(power - 1) / static_cast<double>(power);
    }
    return odd ? 2 / std::numbers::pi * (angle + sine * sum) : sine * sum;
  };
  double low = 0, high = std::numbers::pi / 2;
  for (int step = 0; step < 100; ++step) {
    const double middle = (low + high) / 2;
    (probability(middle) < confidence ? low : high) = middle;
  }
  return std::sqrt(static_cast<double>(freedom)) * std::tan((low + high) / 2);
}

}  // namespace tactile::evaluation
