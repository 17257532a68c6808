#include "tactile/evaluation/confidence_interval.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/random.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::evaluation {
namespace {

constexpr std::size_t fewest_to_draw_from = 3;

std::vector<std::size_t> drawn_from(std::span<const std::size_t> runs, Random& random) {
  std::vector<std::size_t> drawn(runs.size());
  for (std::size_t& run : drawn) run = runs[random.below(runs.size())];
  return drawn;
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

results::Figure figure_of_object(std::span<const std::size_t> runs, const Statistic& statistic,
                                 const results::BootstrapOptions& options) {
  if (runs.empty()) return {};
  return figure_of_draws(statistic({{runs.begin(), runs.end()}}), runs.size(), options,
                         [&](Random& random) { return statistic({drawn_from(runs, random)}); });
}

results::Figure figure_over_objects(const RunsByObject& runs, const Statistic& statistic,
                                    const results::BootstrapOptions& options) {
  RunsByObject filled;
  std::copy_if(runs.begin(), runs.end(), std::back_inserter(filled), [](const auto& object) { return !object.empty(); });
  if (filled.empty()) return {};
  return figure_of_draws(statistic(filled), filled.size(), options, [&](Random& random) {
    RunsByObject drawn(filled.size());
    for (auto& object : drawn) object = drawn_from(filled[random.below(filled.size())], random);
    return statistic(drawn);
  });
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
