#include "tactile/experiments/study/history_claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/study/claim_figures.hpp"

namespace tactile::study {
namespace {

constexpr microseconds shortest{2'000}, marginal{20'000}, chosen{40'000};

/// Accuracies of the same runs at every history.
class Histories {
 public:
  explicit Histories(const std::map<microseconds, std::vector<results::RunConfusion>>& histories) : histories_(histories) {
    for (const auto& [history, runs] : histories_) {
      const auto& first = histories_.begin()->second;
      const bool same = std::equal(runs.begin(), runs.end(), first.begin(), first.end(),
                                   [](const results::RunConfusion& a, const results::RunConfusion& b) {
                                     return a.object == b.object && a.run == b.run && a.training == b.training;
                                   });
      if (!same) throw Error("accuracies of histories on different runs; expected the same runs for each");
    }
    if (!histories_.empty()) {
      objects_ = evaluation::results_by_object(std::span<const results::RunConfusion>(histories_.begin()->second),
                                               evaluation::has_samples);
    }
  }

  /// Of differences of accuracies in points of percent, in steps of one sample of a run.
  evaluation::Range points() const {
    return {-100, 100, histories_.empty() ? 0 : 100 * evaluation::range_of_shares(histories_.begin()->second).step};
  }

  bool has(microseconds history) const { return histories_.contains(history); }
  bool has_others(microseconds history) const { return has(history) && histories_.size() > 1; }
  const std::map<std::string, evaluation::CrossedObject>& objects() const { return objects_; }

  double accuracy(microseconds history, std::span<const std::size_t> runs) const {
    return evaluation::accuracy_over(histories_.at(history), runs).value_or(NAN);
  }

  double mean_accuracy(microseconds history, const evaluation::RunsByObject& objects) const {
    double sum = 0;
    for (const auto& runs : objects) sum += accuracy(history, runs);
    return sum / static_cast<double>(objects.size());
  }

  /// Over all objects [%].
  double mean_percent(microseconds history) const {
    return 100 * mean_accuracy(history, evaluation::all_of(evaluation::without_names(objects_)));
  }

  /// Over objects. @param difference  of mean accuracies, in [-1, 1]
  results::Figure difference_in_points(const std::function<double(const evaluation::RunsByObject&)>& difference,
                                       const results::BootstrapOptions& options) const {
    return evaluation::figure_over_objects(
        evaluation::without_names(objects_),
        [&](const evaluation::RunsByObject& objects) -> std::optional<double> { return 100 * difference(objects); }, options,
        points());
  }

  /// Of equals the shortest.
  microseconds best(std::span<const std::size_t> runs) const {
    microseconds best = histories_.begin()->first;
    for (const auto& [history, confusions] : histories_) {
      if (accuracy(history, runs) > accuracy(best, runs)) best = history;
    }
    return best;
  }

  template <class Take>
  std::vector<microseconds> those(Take take) const {
    std::vector<microseconds> taken;
    for (const auto& [history, runs] : histories_) {
      if (take(history)) taken.push_back(history);
    }
    return taken;
  }

 private:
  const std::map<microseconds, std::vector<results::RunConfusion>>& histories_;
  std::map<std::string, evaluation::CrossedObject> objects_;
};

results::Claim history_2_worst(const Histories& histories, const results::BootstrapOptions& options) {
  results::Claim claim = unmeasured(
      "history-2-worst", results::ClaimScope::every_object,
      "A history of 2 ms is the worst for every object: its accuracy minus the lowest at any other history, of the object "
      "where that is largest",
      "Instantaneous heatmaps (2 ms) are worst for all ten objects", "points", results::Asked::below, 0);
  if (!histories.has_others(shortest)) return claim;
  const auto others = histories.those([](microseconds history) { return history != shortest; });
  const OfRuns less_lowest = [&](std::span<const std::size_t> runs) {
    double lowest = 1;
    for (const microseconds other : others) lowest = std::min(lowest, histories.accuracy(other, runs));
    return 100 * (histories.accuracy(shortest, runs) - lowest);
  };
  take(claim, histories.objects(), less_lowest, histories.points(), options);
  const double furthest = claim.measured.value;
  claim.in_words = fmt::format("2 ms is the worst for {}; {}: {}, where {}.", kept_of(claim),
                               furthest < 0 ? "least so" : "furthest off", furthest_object(claim),
                               furthest > 0   ? fmt::format("another history is {:.2f} points worse", furthest)
                               : furthest < 0 ? fmt::format("it is {:.2f} points below the next", -furthest)
                                              : std::string("another history is just as bad"));
  return claim;
}

results::Claim longer_is_better(const Histories& histories, const results::BootstrapOptions& options) {
  results::Claim claim =
      unmeasured("longer-is-better", results::ClaimScope::over_objects,
                 "Up to 20 ms each longer history is better: the smallest step of the mean accuracy from one to the next",
                 "Increasing the history of events improves the performance", "points", results::Asked::above, 0);
  const auto shorter = histories.those([](microseconds history) { return history <= marginal; });
  if (shorter.size() < 2 || !histories.has(shortest) || !histories.has(marginal)) return claim;
  claim.measured = histories.difference_in_points(
      [&](const evaluation::RunsByObject& objects) {
        double smallest = 1;
        for (std::size_t i = 1; i < shorter.size(); ++i) {
          smallest =
              std::min(smallest, histories.mean_accuracy(shorter[i], objects) - histories.mean_accuracy(shorter[i - 1], objects));
        }
        return smallest;
      },
      options);
  std::vector<std::string> means;
  means.reserve(shorter.size());
  for (const microseconds history : shorter)
    means.push_back(fmt::format("{:.2f} % at {} ms", histories.mean_percent(history), experiments::ms_text(history)));
  claim.in_words = fmt::format("The mean over {} objects is {}.", histories.objects().size(), fmt::join(means, ", "));
  return claim;
}

results::Claim best_history_40(const Histories& histories, const results::BootstrapOptions& options) {
  results::Claim claim =
      unmeasured("best-history-40", results::ClaimScope::over_objects,
                 "A history of 40 ms is the best for more objects than any other: their number minus that of the next one",
                 "40 ms is the best for five objects, 50 ms for three, 20 ms for two", "objects", results::Asked::above, 0);
  if (!histories.has_others(chosen)) return claim;
  std::map<microseconds, std::size_t> counts;
  for (const auto& object : histories.objects()) ++counts[histories.best(evaluation::indexes_of(object.second))];
  const evaluation::Statistic lead = [&](const evaluation::RunsByObject& objects) -> std::optional<double> {
    std::map<microseconds, int> best;
    for (const auto& runs : objects) ++best[histories.best(runs)];
    int next = 0;
    for (const auto& [history, count] : best) {
      if (history != chosen) next = std::max(next, count);
    }
    return best[chosen] - next;
  };
  const auto most = static_cast<double>(histories.objects().size());
  const evaluation::CrossedResults objects = evaluation::without_names(histories.objects());
  const auto runs = static_cast<double>(evaluation::run_count(objects));
  claim.measured = evaluation::figure_over_objects(objects, lead, options, {.lowest = -most, .highest = most, .step = 2 * runs});
  claim.kept = counts[chosen];
  claim.of = histories.objects().size();
  std::string others;
  for (const auto& [history, count] : counts) {
    if (history != chosen)
      others += fmt::format("{}{} ms for {}", others.empty() ? "; " : ", ", experiments::ms_text(history), count);
  }
  claim.in_words = fmt::format("40 ms is the best for {}{} (of equals, the shortest).", kept_of(claim), others);
  return claim;
}

results::Claim marginal_past_20(const Histories& histories, const results::BootstrapOptions& options) {
  results::Claim claim =
      unmeasured("marginal-past-20", results::ClaimScope::over_objects,
                 "Past 20 ms a longer history gains less than a point: the highest mean accuracy past 20 ms minus that at 20 ms",
                 "Improvements become marginal after 20 ms", "points", results::Asked::below, 1);
  const auto longer = histories.those([](microseconds history) { return history > marginal; });
  if (!histories.has(marginal) || longer.empty()) return claim;
  claim.measured = histories.difference_in_points(
      [&](const evaluation::RunsByObject& objects) {
        double highest = 0;
        for (const microseconds history : longer) highest = std::max(highest, histories.mean_accuracy(history, objects));
        return highest - histories.mean_accuracy(marginal, objects);
      },
      options);
  if (std::isnan(claim.measured.value)) return claim;
  const microseconds best = *std::max_element(longer.begin(), longer.end(), [&](microseconds a, microseconds b) {
    return histories.mean_percent(a) < histories.mean_percent(b);
  });
  claim.in_words = fmt::format("The mean over {} objects is {:.2f} % at 20 ms, and past that {:.2f} % at best, at {} ms.",
                               histories.objects().size(), histories.mean_percent(marginal), histories.mean_percent(best),
                               experiments::ms_text(best));
  return claim;
}

results::Claim accuracy_at_40(const Histories& histories, const results::BootstrapOptions& options) {
  results::Claim claim =
      unmeasured("accuracy-at-40", results::ClaimScope::every_object,
                 "With 40 ms the accuracy is above 95 % for every object: that of the lowest object",
                 "The average accuracy of the nine test runs exceeds 95 % for all ten objects", "%", results::Asked::above, 95);
  if (!histories.has(chosen)) return claim;
  evaluation::Range range = histories.points();
  range.lowest = 0;
  take(
      claim, histories.objects(), [&](std::span<const std::size_t> runs) { return 100 * histories.accuracy(chosen, runs); },
      range, options);
  claim.in_words = fmt::format("Above 95 % for {}; the lowest is {} with {:.2f} %.", kept_of(claim), furthest_object(claim),
                               claim.measured.value);
  return claim;
}

/// One history can disprove a claim that compares all up to `longest`; to prove it takes all.
void judge_comparison(results::Claim& claim, const std::vector<microseconds>& untrained,
                      microseconds longest = microseconds::max()) {
  judge(claim);
  if (claim.outcome != results::Outcome::holds) return;
  std::vector<std::string> lacking;
  lacking.reserve(untrained.size());
  for (const microseconds history : untrained) {
    if (history <= longest) lacking.push_back(experiments::ms_text(history));
  }
  if (lacking.empty()) return;
  claim.outcome = results::Outcome::cannot_tell;
  claim.why = fmt::format("no model was trained for {} ms, which the paper compares", fmt::join(lacking, ", "));
  claim.can_be_decided = false;
}

}  // namespace

std::vector<results::Claim> history_claims(const ClaimInputs& inputs, const results::BootstrapOptions& options) {
  const Histories histories(inputs.histories);
  results::Claim worst = history_2_worst(histories, options);
  results::Claim longer = longer_is_better(histories, options);
  results::Claim best = best_history_40(histories, options);
  results::Claim past_20 = marginal_past_20(histories, options);
  results::Claim at_40 = accuracy_at_40(histories, options);
  for (results::Claim* claim : {&worst, &best, &past_20}) judge_comparison(*claim, inputs.untrained);
  judge_comparison(longer, inputs.untrained, marginal);
  judge(at_40);
  return {worst, longer, best, past_20, at_40};
}

}  // namespace tactile::study
