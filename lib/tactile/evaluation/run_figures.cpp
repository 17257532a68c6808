#include "tactile/evaluation/run_figures.hpp"

#include <limits>
#include <map>
#include <set>

namespace tactile::evaluation {

void RunFigures::divide(std::span<const results::JudgedRun* const> runs) {
  std::set<std::string_view> worlds;
  for (const results::JudgedRun* run : runs) {
    if (run != nullptr) worlds.insert(run->world);
  }
  over_worlds_ = worlds.size() >= fewest_worlds;
  std::map<std::string, CrossedObject> units;
  std::map<std::string, std::map<std::string, std::size_t>> run_numbers;
  std::map<std::string, std::size_t> object_numbers;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    object_of_.push_back(0);
    if (runs[i] == nullptr) continue;
    const results::JudgedRun& run = *runs[i];
    object_of_.back() = object_numbers.emplace(run.object, object_numbers.size()).first->second;
    const std::string unit = over_worlds_ ? run.world : run.world + "/" + run.object;
    // A run without a name is one of its own.
    std::string name = run.run.empty() ? "#" + std::to_string(i) : run.run;
    if (over_worlds_) name.insert(0, run.object + "/");
    auto& numbers = run_numbers[unit];
    units[unit].push_back({over_worlds_ ? 0 : run.training, numbers.emplace(std::move(name), numbers.size()).first->second, i});
  }
  units_ = without_names(units);
  are_few_objects_ = !over_worlds_ && units_.size() < fewest_objects;
}

results::Figure RunFigures::of_all(const Statistic& statistic, const Range& range) const {
  if (options_ == nullptr)
    return {.value = units_.empty() ? std::numeric_limits<double>::quiet_NaN()
                                    : statistic(all_of(units_)).value_or(std::numeric_limits<double>::quiet_NaN())};
  return are_few_objects_ ? figure_of_these_objects(units_, statistic, *options_, range)
                          : figure_over_objects(units_, statistic, *options_, range);
}

results::Figure RunFigures::of_objects(const Statistic& statistic, const Range& range) const {
  if (!over_worlds_) return of_all(statistic, range);
  const Statistic mean_over_worlds = [&](const RunsByObject& worlds) -> std::optional<double> {
    double sum = 0, count = 0;
    for (const std::vector<std::size_t>& world : worlds) {
      std::map<std::size_t, std::vector<std::size_t>> objects;
      for (const std::size_t i : world) objects[object_of_[i]].push_back(i);
      RunsByObject lists;
      for (auto& object : objects) lists.push_back(std::move(object.second));
      if (const auto value = statistic(lists)) sum += *value, ++count;
    }
    return count > 0 ? std::optional(sum / count) : std::nullopt;
  };
  return of_all(mean_over_worlds, range);
}

}  // namespace tactile::evaluation
