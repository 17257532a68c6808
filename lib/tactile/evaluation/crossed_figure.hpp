#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/evaluation/statistic.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::evaluation {

/// A result of one training on one run of an object.
struct CrossedCell {
  std::size_t training = 0;  ///< shared by all objects
  std::size_t run = 0;       ///< within its object
  std::size_t index = 0;     ///< its place in the caller's list of results
};
using CrossedObject = std::vector<CrossedCell>;  ///< cells may be missing: a training is not judged on the runs it learned from
using CrossedResults = std::vector<CrossedObject>;

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

/// The largest number of trainings that are judged on the same run.
unsigned most_results_of_a_run(const CrossedResults& objects);

std::size_t result_count(const CrossedResults& objects);

/// The values that a figure may have; its interval stays within them.
struct Range {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
  /// What one event changes of one result: an error of its samples, an alarm in its time, a tick of its delay; 0: not known. It
  /// is needed only where all results give the same.
  double step = 0;
};

/// Whether a figure can have bounds: of three or more objects, or runs of one object, and not of two trainings.
bool allows_bounds(std::size_t units, std::size_t trainings);

/// The figure of one object over trainings, runs, and what they have in common. Half of a normal figure's interval is
///
///   h = sqrt(t(n - 1)^2 V_runs + t(K - 1)^2 max(0, V_trainings - V_both))
///
/// t(d) is the quantile of Student's distribution with d degrees of freedom. V are variances by the jackknife: from leaving out
/// each run, each training, and each pair of them. V_both, the noise of single results, is in both others. Where drawing with
/// replacement spreads the figure over 10 % wider than the jackknife says, as it may for a median, the draws count, and nothing
/// is subtracted. With one training, V_trainings is 0, and the interval holds for this training only.
///
/// A figure with limits is seldom normal near them. With p = (value - lowest) / (highest - lowest), as many independent trials
/// with the same uncertainty are
///
///   N = p (1 - p) (highest - lowest)^2 (z / h)^2,   z: the quantile of the normal distribution
///
/// and the bounds are those of p N successes in N trials, by `binomial_bounds`, which take any real number. Without a highest
/// value, 1000 times the value takes its place. A figure without limits, and a median at one of them, has the bounds value -+ h.
///
/// Where all results give the same, h is not known. Of n equal runs at most 3.69 / n are different by a step (Garwood's bound for
/// none, at 95 %), which is h then; at a limit, N = n (highest - lowest) / step, the number of events that could be seen.
///
/// The interval contains the value. It has no bounds where there are fewer than three runs or two trainings, where more than half
/// of the draws give nothing, and where all results give the same and the step is not known. Figures with the same cells are
/// made from the same draws; a difference is a `statistic` that subtracts.
///
/// @param statistic  of the cells' indexes, in one list per object, repeated as often as drawn; of no list that is empty
/// Source: B. Efron and C. Stein, The jackknife estimate of variance, Annals of Statistics 9 (1981); A. B. Owen, The pigeonhole
/// bootstrap, Annals of Applied Statistics 1 (2007), for V of crossed trainings and runs; S. Banerjee, Approximate confidence
/// interval for linear functions of means of k populations when the population variances are not equal, Sankhya 22 (1960), for
/// the sum of t^2 V; E. L. Korn and B. I. Graubard, Confidence intervals for proportions with small expected number of positive
/// counts estimated from survey data, Survey Methodology 24 (1998), for N. How often such an interval contains the true value is
/// in docs/numerics/.
results::Figure figure_of_object(const CrossedObject& cells, const Statistic& statistic,
                                 const results::BootstrapOptions& options = {}, const Range& range = {});

/// The same of several objects that stay: trainings are drawn, and the runs of each object. V_runs is the sum of the objects'
/// variances; its degrees of freedom are Satterthwaite's, (sum V_o)^2 / sum(V_o^2 / (n_o - 1)), rounded down. There are no bounds
/// where an object has fewer than three runs.
results::Figure figure_of_these_objects(const CrossedResults& objects, const Statistic& statistic,
                                        const results::BootstrapOptions& options = {}, const Range& range = {});

/// The same over objects: they take the place of the runs above. An object is left out or drawn with all of its runs, so the
/// effect of its runs is in that of the objects. Objects without cells are passed over.
results::Figure figure_over_objects(const CrossedResults& objects, const Statistic& statistic,
                                    const results::BootstrapOptions& options = {}, const Range& range = {});

/// The value that Student's t exceeds in absolute value with the probability 1 - confidence.
/// @param freedom  its degrees of freedom, >= 1
/// @param confidence  in (0, 1)
/// Source: M. Abramowitz and I. A. Stegun, Handbook of Mathematical Functions (1964), 26.7.3 and 26.7.4.
double student_quantile(std::size_t freedom, double confidence);

}  // namespace tactile::evaluation
