#include "interval_methods.hpp"

#include <map>
#include <set>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::study {
namespace {

using evaluation::CrossedCell;
using evaluation::CrossedResults;
using evaluation::RunsByObject;

bool of_one_object(const Trial& trial) { return trial.objects.size() == 1; }

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

/// Values of the figure, with objects drawn, runs within them, and trainings.
std::vector<double> drawn_values(const Trial& trial, const results::BootstrapOptions& options) {
  const auto objects = by_run(trial.objects);
  const std::size_t trainings = trainings_of(trial);
  Random random(options.seed);
  std::vector<double> values;
  for (std::size_t i = 0; i < options.draws; ++i) {
    std::vector<std::size_t> times(trainings);
    for (std::size_t k = 0; k < trainings; ++k) ++times[random.below(trainings)];
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

/// The middle of the values that are drawn.
Bounds percentile(const Trial& trial, const results::BootstrapOptions& options) {
  const std::vector<double> values = drawn_values(trial, options);
  const double outside = (1 - options.confidence) / 2;
  if (values.empty()) return std::nullopt;
  return std::pair{quantile(values, outside), quantile(values, 1 - outside)};
}

}  // namespace

Bounds bounds_of(const results::Figure& figure) {
  if (!figure.has_interval()) return std::nullopt;
  return std::pair{*figure.low, *figure.high};
}

const std::vector<IntervalMethod>& interval_methods() {
  static const std::vector<IntervalMethod> methods{
      {"the one in use", chosen},
      {"the same without its reserve", chosen_without_reserve},
      {"percentile", percentile},
  };
  return methods;
}

}  // namespace tactile::study
