#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/results/figure.hpp"

namespace tactile::evaluation {

/// Results by their index, one list for each object. A drawn result may stand in it several times.
using RunsByObject = std::vector<std::vector<std::size_t>>;

/// A figure of the given results; nothing where there is nothing to measure, such as a delay of runs without a detection.
using Statistic = std::function<std::optional<double>(const RunsByObject&)>;

/// The result of one training on one run of an object.
struct CrossedCell {
  std::size_t training = 0;  ///< the same for all objects
  std::size_t run = 0;       ///< within the object
  std::size_t index = 0;     ///< its place in the caller's list of results
};

/// The results of one object. Some may be missing: no training is judged on a run that it learned from.
using CrossedObject = std::vector<CrossedCell>;
using CrossedResults = std::vector<CrossedObject>;

/// The figure of one object: its runs and the trainings are drawn with replacement. An interval holds the middle 95 % of what the
/// draws give.
///
/// Every figure with the same number of runs and trainings is made from the same draws, so figures of the same runs are paired; a
/// difference is a `statistic` that subtracts. Draws that give nothing are left out; fewer than half left, and there is no
/// interval.
results::Figure figure_of_object(const CrossedObject& cells, const Statistic& statistic,
                                 const results::BootstrapOptions& options = {});

/// The figure over objects: trainings and objects are drawn with replacement, then as many runs within each object as it has.
results::Figure figure_over_objects(const CrossedResults& objects, const Statistic& statistic,
                                    const results::BootstrapOptions& options = {});

/// The results of each object that has some, by name; those for which `taken` is false are left out. Without the id of a run,
/// each result is of a run of its own.
template <class Result, class Taken>
std::map<std::string, CrossedObject> results_by_object(std::span<const Result> results, Taken taken) {
  std::map<std::string, CrossedObject> objects;
  std::map<std::string, std::map<std::string, std::size_t>> runs;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (!taken(results[i])) continue;
    auto& numbers = runs[results[i].object];
    const std::string name = results[i].run.empty() ? "#" + std::to_string(i) : results[i].run;
    const std::size_t run = numbers.emplace(name, numbers.size()).first->second;
    objects[results[i].object].push_back({results[i].training, run, i});
  }
  return objects;
}

/// The same without the names.
CrossedResults without_names(const std::map<std::string, CrossedObject>& objects);

/// The places of the results, each once.
std::vector<std::size_t> indexes_of(const CrossedObject& cells);
RunsByObject all_of(const CrossedResults& objects);

/// A statistic that averages over objects what `of_object` gives of each one's runs; objects that give nothing are left out.
Statistic mean_over_objects(std::function<std::optional<double>(std::span<const std::size_t>)> of_object);

/// An upper bound on the expected number of rare events, where `count` occurred: the mean m of a Poisson distribution with
/// P(X <= count | m) = (1 - confidence) / 2, the upper end of the exact two-sided interval; 3.69 for a count of 0, at 95 %.
/// Source: F. Garwood, Fiducial limits for the Poisson distribution, Biometrika 28 (1936).
double poisson_upper_bound(std::uint64_t count, double confidence = 0.95);

}  // namespace tactile::evaluation
