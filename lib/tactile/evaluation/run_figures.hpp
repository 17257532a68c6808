#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/results/judged_run.hpp"

namespace tactile::evaluation {

inline constexpr std::size_t fewest_worlds = 3, fewest_objects = 3;  ///< that intervals are over

/// Makes figures of results of runs, each with its 95 % interval.
///
/// Intervals are over worlds, where there are three or more: a world has objects and trainings of its own, so their effect is in
/// that of the worlds. Else they are over objects and trainings, as `figure_over_objects`; of one or two objects, over their
/// runs, as `figure_of_these_objects`.
class RunFigures {
 public:
  /// @param results  each a `JudgedRun`; statistics know them by their index. Those that are not `taken` are left out
  /// @param options  null: values without intervals. Else it must outlive the figures
  template <class Result, class Taken>
  RunFigures(std::span<const Result> results, const results::BootstrapOptions* options, Taken taken) : options_(options) {
    std::vector<const results::JudgedRun*> runs;
    for (const Result& result : results) runs.push_back(taken(result) ? &result : nullptr);
    divide(runs);
  }

  const char* unit_name() const { return over_worlds_ ? "worlds" : are_few_objects_ ? "runs" : "objects"; }
  const CrossedResults& units() const { return units_; }

  /// @param statistic  of all results together, in one list for each unit
  results::Figure of_all(const Statistic& statistic, const Range& range = {}) const;

  /// @param statistic  of one list for each object. Over worlds, the figure is the mean of what it gives for each of them
  results::Figure of_objects(const Statistic& statistic, const Range& range = {}) const;

 private:
  void divide(std::span<const results::JudgedRun* const> runs);

  const results::BootstrapOptions* options_;
  CrossedResults units_;
  std::vector<std::size_t> object_of_;  // of each result, by number
  bool over_worlds_ = false, are_few_objects_ = false;
};

/// The names of the objects that have results, ascending.
template <class Result, class Taken>
std::vector<std::string> objects_of(std::span<const Result> results, Taken taken) {
  std::vector<std::string> names;
  for (const auto& object : results_by_object(results, taken)) names.push_back(object.first);
  return names;
}

}  // namespace tactile::evaluation
