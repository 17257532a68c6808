#include "tactile/evaluation/confidence_interval.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/random.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::evaluation {
namespace {

constexpr std::size_t fewest_to_draw_from = 3;

/// The different values of a factor in these results.
std::vector<std::size_t> levels_of(const CrossedObject& cells, std::size_t CrossedCell::*factor) {
  std::vector<std::size_t> levels;
  for (const CrossedCell& cell : cells) levels.push_back(cell.*factor);
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  return levels;
}

/// How often each level was drawn, by its number.
using Times = std::vector<unsigned>;

Times drawn_times(const std::vector<std::size_t>& levels, Random& random) {
  Times times(levels.empty() ? 0 : levels.back() + 1);
  for (std::size_t i = 0; i < levels.size(); ++i) ++times[levels[random.below(levels.size())]];
  return times;
}

std::vector<std::size_t> drawn_results(const CrossedObject& cells, const Times& trainings, Random& random) {
  const Times runs = drawn_times(levels_of(cells, &CrossedCell::run), random);
  std::vector<std::size_t> drawn;
  for (const CrossedCell& cell : cells) drawn.insert(drawn.end(), trainings[cell.training] * runs[cell.run], cell.index);
  return drawn;
}

std::vector<std::size_t> trainings_in(const CrossedResults& objects) {
  CrossedObject all;
  for (const CrossedObject& cells : objects) all.insert(all.end(), cells.begin(), cells.end());
  return levels_of(all, &CrossedCell::training);
}

results::Figure figure_of_draws(std::optional<double> value, std::size_t n, const results::BootstrapOptions& options,
                                const std::function<std::optional<double>(Random&)>& draw) {
  results::Figure figure;
  figure.n = n;
  if (value) figure.value = *value;
  if (!value || n < fewest_to_draw_from) return figure;
  Random random(seed_for(options.seed, {"bootstrap"}));
  std::vector<double> values;
  for (std::size_t i = 0; i < options.draws; ++i) {
    if (const auto drawn = draw(random)) values.push_back(*drawn);
  }
  if (2 * values.size() < options.draws) return figure;
  const double outside = (1 - options.confidence) / 2;
  figure.low = quantile(values, outside);
  figure.high = quantile(values, 1 - outside);
  return figure;
}

}  // namespace

results::Figure figure_of_object(const CrossedObject& cells, const Statistic& statistic,
                                 const results::BootstrapOptions& options) {
  if (cells.empty()) return {};
  const std::vector<std::size_t> trainings = trainings_in({cells});
  results::Figure figure =
      figure_of_draws(statistic({indexes_of(cells)}), levels_of(cells, &CrossedCell::run).size(), options,
                      [&](Random& random) { return statistic({drawn_results(cells, drawn_times(trainings, random), random)}); });
  figure.trainings = trainings.size();
  return figure;
}

results::Figure figure_over_objects(const CrossedResults& objects, const Statistic& statistic,
                                    const results::BootstrapOptions& options) {
  CrossedResults filled;
  std::copy_if(objects.begin(), objects.end(), std::back_inserter(filled), [](const auto& cells) { return !cells.empty(); });
  if (filled.empty()) return {};
  const std::vector<std::size_t> trainings = trainings_in(filled);
  results::Figure figure = figure_of_draws(statistic(all_of(filled)), filled.size(), options, [&](Random& random) {
    const Times times = drawn_times(trainings, random);
    RunsByObject drawn(filled.size());
    for (auto& object : drawn) object = drawn_results(filled[random.below(filled.size())], times, random);
    return statistic(drawn);
  });
  figure.trainings = trainings.size();
  return figure;
}

CrossedResults without_names(const std::map<std::string, CrossedObject>& objects) {
  CrossedResults results;
  for (const auto& object : objects) results.push_back(object.second);
  return results;
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

Statistic mean_over_objects(std::function<std::optional<double>(std::span<const std::size_t>)> of_object) {
  return [of_object = std::move(of_object)](const RunsByObject& runs) -> std::optional<double> {
    double sum = 0;
    std::size_t objects = 0;
    for (const auto& object : runs) {
      const auto value = of_object(object);
      if (!value) continue;
      sum += *value;
      ++objects;
    }
    if (objects == 0) return std::nullopt;
    return sum / static_cast<double>(objects);
  };
}

double poisson_upper_bound(std::uint64_t count, double confidence) {
  const double share = (1 - confidence) / 2;
  // No mean asked for lies below the count, so from there on down each term is less than the one before.
  const auto share_up_to_count = [count](double mean) {
    auto k = static_cast<double>(count);
    double term = std::exp(k * std::log(mean) - mean - std::lgamma(k + 1)), sum = term;
    for (; k > 0 && term > 1e-17 * sum; --k) sum += term *= k / mean;
    return sum;
  };
  double low = static_cast<double>(count), high = low + 10;
  while (share_up_to_count(high) > share) high *= 2;
  if (low == 0) low = 1e-9;
  for (int step = 0; step < 100; ++step) {
    const double middle = (low + high) / 2;
    (share_up_to_count(middle) > share ? low : high) = middle;
  }
  return high;
}

}  // namespace tactile::evaluation
