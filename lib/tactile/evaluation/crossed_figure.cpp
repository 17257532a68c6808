#include "tactile/evaluation/crossed_figure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "tactile/core/random.hpp"

namespace tactile::evaluation {
namespace {

constexpr std::size_t fewest_units = 3;
constexpr std::size_t fewest_to_subtract = 3;  // trainings; the one difference of two says too little of what is noise
// Of the misses that are allowed, the share that Student's distribution gets. The rest is for what is not normal: figures near a
// limit are skewed further than the scale corrects. Chosen by the study of docs/numerics/.
constexpr double share_of_misses = 0.7;
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

/// The scale on which an interval is made.
class Scale {
 public:
  Scale(const Range& range, double value)
      : lowest_(range.lowest), highest_(range.highest), bounded_(value > range.lowest && value < range.highest) {
    below_ = std::isfinite(lowest_) ? value - lowest_ : 0;
    above_ = std::isfinite(highest_) ? highest_ - value : 0;
  }

  /// `n` things were there. Without one of them the figure may be at a limit, which is infinitely far: it counts as the n-th part
  /// of the value's distance.
  double of(double x, std::size_t n) const {
    if (!bounded_) return x;
    const auto share = 1 / static_cast<double>(n);
    double result = std::isfinite(lowest_) || std::isfinite(highest_) ? 0 : x;
    if (std::isfinite(lowest_)) result += std::log(std::max(x - lowest_, share * below_));
    if (std::isfinite(highest_)) result -= std::log(std::max(highest_ - x, share * above_));
    return result;
  }
  double gradient() const {
    if (!bounded_ || !(below_ > 0 || above_ > 0)) return 1;
    return (below_ > 0 ? 1 / below_ : 0) + (above_ > 0 ? 1 / above_ : 0);
  }
  /// The value moved by `change` on the scale, within the range.
  double moved(double value, double change) const {
    double x = value + change;
    if (bounded_ && below_ > 0 && above_ > 0) {
      const double odds = below_ / above_ * std::exp(change);
      x = std::isinf(odds) ? highest_ : lowest_ + (highest_ - lowest_) * (odds / (1 + odds));
    } else if (bounded_ && below_ > 0) {
      x = lowest_ + below_ * std::exp(change);
    } else if (bounded_ && above_ > 0) {
      x = highest_ - above_ * std::exp(-change);
    }
    return change < 0 ? std::min(value, std::max(x, lowest_)) : std::max(value, std::min(x, highest_));
  }

 private:
  double lowest_, highest_, below_ = 0, above_ = 0;
  bool bounded_;
};

double sum_of_squares(std::span<const double> values) {
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum;
}

/// What a figure is without each training, object or run.
struct Deletions {
  std::vector<double> values;
  std::size_t of = 0;  // how many there were

  /// (n - 1) / n sum of (value - mean)^2, on a scale if one is given.
  double variance(const Scale* scale = nullptr) const {
    if (values.size() < 2) return 0;
    std::vector<double> scaled = values;
    if (scale) std::transform(values.begin(), values.end(), scaled.begin(), [&](double x) { return scale->of(x, of); });
    const auto n = static_cast<double>(values.size());
    return (n - 1) / n * sum_of_squares(scaled);
  }
};

Deletions deletions(Crossing& crossing, Level level, std::pair<std::size_t, std::size_t> group) {
  Deletions deletions{{}, group.second - group.first};
  TimesTaken weights = crossing.all();
  for (std::size_t i = group.first; i < group.second; ++i) {
    weights[level][i] = 0;
    if (const auto value = crossing.value(weights)) deletions.values.push_back(*value);
    weights[level][i] = 1;
  }
  return deletions;
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
  double on_scale = 0;
  bool rough = false;  // it comes from draws
  std::size_t freedom = 1;
};

std::optional<Variance> variance_over(Crossing& crossing, Level level, const Scale& scale,
                                      const results::BootstrapOptions& options) {
  if (crossing.count(level) < 2) return Variance{};
  double plain = 0, on_scale = 0, squares = 0;
  std::size_t fewest = crossing.smallest_group(level) - 1;
  for (const auto& group : crossing.groups(level)) {
    const Deletions without = deletions(crossing, level, group);
    const double of_group = without.variance(&scale);
    plain += without.variance();
    on_scale += of_group;
    squares += of_group * of_group / static_cast<double>(group.second - group.first - 1);
  }
  const std::size_t freedom =
      squares > 0 ? std::max(fewest, static_cast<std::size_t>(on_scale * on_scale / squares * (1 + 1e-9))) : fewest;
  const auto drawn = variance_of_draws(crossing, level, (options.draws + 1) / 2, options.seed);
  if (!drawn) return std::nullopt;
  if (*drawn <= rough * plain) return Variance{on_scale, false, freedom};
  return Variance{std::max(on_scale, *drawn * scale.gradient() * scale.gradient()), true, freedom};
}

/// The part of both variances that comes from single results: from the figure without each pair of a training and one of a group.
double variance_of_both(Crossing& crossing, Level level, std::pair<std::size_t, std::size_t> group, const Scale& scale) {
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
      const double x = table[row * columns + column] = scale.of(*value, rows * columns);
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

double variance_of_both(Crossing& crossing, Level level, const Scale& scale) {
  double sum = 0;
  for (const auto& group : crossing.groups(level)) sum += variance_of_both(crossing, level, group, scale);
  return sum;
}

results::Figure figure_of(Crossing& crossing, Level level, const results::BootstrapOptions& options, const Range& range) {
  results::Figure figure;
  figure.n = crossing.count(level);
  if (figure.n == 0) return figure;
  figure.trainings = crossing.count(by_training);
  const auto value = crossing.value(crossing.all());
  if (value) figure.value = *value;
  if (!value || crossing.smallest_group(level) < fewest_units) return figure;
  const Scale scale(range, *value);
  const auto of_units = variance_over(crossing, level, scale, options);
  const auto of_trainings = variance_over(crossing, by_training, scale, options);
  if (!of_units || !of_trainings) return figure;
  const std::size_t count = crossing.count(by_training);
  const double confidence = 1 - share_of_misses * (1 - options.confidence);
  const double t_units = student_quantile(of_units->freedom, confidence);
  double square = t_units * t_units * of_units->on_scale;
  if (count > 1) {
    const bool subtracts = count >= fewest_to_subtract && !of_units->rough && !of_trainings->rough;
    const double both = subtracts ? variance_of_both(crossing, level, scale) : 0;
    const double t = student_quantile(count - 1, confidence);
    square += t * t * std::max(0.0, of_trainings->on_scale - both);
  }
  // Sums of the same numbers in another order differ in their last bits.
  if (std::sqrt(square) > 1e-12 * (std::abs(*value) * scale.gradient() + 1e-300)) {
    figure.low = scale.moved(*value, -std::sqrt(square));
    figure.high = scale.moved(*value, std::sqrt(square));
  } else if (range.step > 0) {
    const double unseen = poisson_upper_bound(0, options.confidence) * range.step / static_cast<double>(figure.n);
    figure.low = std::min(*value, std::max(*value - unseen, range.lowest));
    figure.high = std::max(*value, std::min(*value + unseen, range.highest));
  }
  return figure;
}

}  // namespace

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

double one_run_of(const CrossedResults& objects) {
  std::size_t runs = 0;
  for (const CrossedObject& cells : objects) {
    std::set<std::size_t> of_object;
    for (const CrossedCell& cell : cells) of_object.insert(cell.run);
    runs += of_object.size();
  }
  return static_cast<double>(objects.size()) / static_cast<double>(std::max<std::size_t>(runs, 1));
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

std::optional<results::VarianceShares> variance_shares(const CrossedResults& objects, const Statistic& statistic,
                                                       const results::BootstrapOptions& options) {
  Crossing crossing(objects, statistic);
  if (crossing.count(by_object) < fewest_units) return std::nullopt;
  const auto value = crossing.value(crossing.all());
  if (!value) return std::nullopt;
  const Scale plain({}, *value);
  const auto of_trainings = variance_over(crossing, by_training, plain, options);
  const auto of_objects = variance_over(crossing, by_object, plain, options);
  const auto of_runs = variance_over(crossing, by_run, plain, options);
  if (!of_trainings || !of_objects || !of_runs) return std::nullopt;
  const bool subtracts = crossing.count(by_training) > 1 && !of_trainings->rough && !of_objects->rough;
  const double both = subtracts ? variance_of_both(crossing, by_object, plain) : 0;
  const results::VarianceShares shares{std::max(0.0, of_trainings->on_scale - both),
                                       std::max(0.0, of_objects->on_scale - of_runs->on_scale), of_runs->on_scale};
  const double sum = shares.training + shares.object + shares.run;
  if (!(std::sqrt(sum) > 1e-12 * std::abs(*value))) return std::nullopt;
  return results::VarianceShares{shares.training / sum, shares.object / sum, shares.run / sum};
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
