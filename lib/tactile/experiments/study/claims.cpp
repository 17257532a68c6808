#include "tactile/experiments/study/claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/study/claim_rules.hpp"

namespace tactile::study {
namespace {

constexpr const char* exception_object = "plastic-container";
constexpr double near_points = 5;  ///< taken for "comparable"
constexpr microseconds shortest{2'000}, marginal{20'000}, chosen{40'000};

results::Claim unmeasured(std::string id, results::ClaimScope scope, std::string claim, std::string paper, std::string unit,
                          results::Asked asked, double limit) {
  results::Claim empty;
  empty.id = std::move(id);
  empty.scope = scope;
  empty.claim = std::move(claim);
  empty.paper = std::move(paper);
  empty.unit = std::move(unit);
  empty.asked = asked;
  empty.limit = limit;
  return empty;
}

/// A figure of one object by its runs; nothing where there is nothing to measure.
using OfRuns = std::function<std::optional<double>(std::span<const std::size_t>)>;

bool has_samples(const results::RunConfusion& run) { return run.confusion.samples() > 0; }

double accuracy_over(std::span<const results::RunConfusion> all, std::span<const std::size_t> runs) {
  results::Confusion sum;
  for (const std::size_t run : runs) sum += all[run].confusion;
  return sum.accuracy().value_or(NAN);
}

/// Intervals that hold for `count` objects at once.
results::BootstrapOptions wide_for(std::size_t count, results::BootstrapOptions options) {
  options.confidence = 1 - (1 - options.confidence) / static_cast<double>(std::max<std::size_t>(count, 1));
  return options;
}

/// Sets the objects' figures, the outermost of them as the measured one, and the number of objects that the claim is true for.
void take(results::Claim& claim, ObjectFigures figures, const results::Figure& mean) {
  claim.mean = mean;
  claim.measured = claim.asked == results::Asked::below ? largest_of(figures) : smallest_of(figures);
  claim.objects = std::move(figures.objects);
  claim.kept = 0;
  claim.of = 0;
  for (const auto& [name, figure] : claim.objects) {
    if (std::isnan(figure.value)) continue;
    ++*claim.of;
    *claim.kept += (claim.asked == results::Asked::below ? figure.value < claim.limit : figure.value > claim.limit) ? 1U : 0U;
  }
}

/// The same by a figure of each object.
void take(results::Claim& claim, const std::map<std::string, evaluation::CrossedObject>& objects, const OfRuns& of_runs,
          const evaluation::Range& range, const results::BootstrapOptions& options) {
  const evaluation::Statistic mean = evaluation::mean_over_objects(of_runs);
  ObjectFigures figures;
  for (const auto& [name, cells] : objects) {
    figures.objects[name] = evaluation::figure_of_object(cells, mean, options, range);
    figures.wide[name] = evaluation::figure_of_object(cells, mean, wide_for(objects.size(), options), range);
  }
  take(claim, std::move(figures), evaluation::figure_of_these_objects(evaluation::without_names(objects), mean, options, range));
}

/// The object whose value is `claim.measured`.
std::string furthest_object(const results::Claim& claim) {
  for (const auto& [name, figure] : claim.objects) {
    if (figure.value == claim.measured.value) return name;
  }
  return {};
}

/// "3 of 10 objects", "1 of 1 object"
std::string kept_of(const results::Claim& claim) {
  return fmt::format("{} of {} object{}", claim.kept.value_or(0), claim.of.value_or(0), claim.of == std::size_t{1} ? "" : "s");
}

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
      objects_ = evaluation::results_by_object(std::span<const results::RunConfusion>(histories_.begin()->second), has_samples);
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
    return accuracy_over(histories_.at(history), runs);
  }

  double mean_accuracy(microseconds history, const evaluation::RunsByObject& objects) const {
    double sum = 0;
    for (const auto& runs : objects) sum += accuracy(history, runs);
    return sum / static_cast<double>(objects.size());
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
      "A history of 2 ms is the worst for every object: its accuracy less the lowest at any other history, of the object "
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

results::Claim best_history_40(const Histories& histories, const results::BootstrapOptions& options) {
  results::Claim claim =
      unmeasured("best-history-40", results::ClaimScope::over_objects,
                 "A history of 40 ms is the best for more objects than any other: their number less that of the next one",
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
  claim.measured = evaluation::figure_over_objects(evaluation::without_names(histories.objects()), lead, options,
                                                   {.lowest = -most, .highest = most, .step = 2 * most});
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
                 "Past 20 ms a longer history gains less than a point: the highest mean accuracy past 20 ms less that at 20 ms",
                 "Improvements become marginal after 20 ms", "points", results::Asked::below, 1);
  const auto longer = histories.those([](microseconds history) { return history > marginal; });
  if (!histories.has(marginal) || longer.empty()) return claim;
  const evaluation::CrossedResults cells = evaluation::without_names(histories.objects());
  const evaluation::RunsByObject all = evaluation::all_of(cells);
  claim.measured = evaluation::figure_over_objects(
      cells,
      [&](const evaluation::RunsByObject& objects) -> std::optional<double> {
        double highest = 0;
        for (const microseconds history : longer) highest = std::max(highest, histories.mean_accuracy(history, objects));
        return 100 * (highest - histories.mean_accuracy(marginal, objects));
      },
      options, histories.points());
  if (std::isnan(claim.measured.value)) return claim;
  const microseconds best = *std::max_element(longer.begin(), longer.end(), [&](microseconds a, microseconds b) {
    return histories.mean_accuracy(a, all) < histories.mean_accuracy(b, all);
  });
  claim.in_words = fmt::format("The mean over {} objects is {:.2f} % at 20 ms, and past that {:.2f} % at best, at {} ms.",
                               all.size(), 100 * histories.mean_accuracy(marginal, all), 100 * histories.mean_accuracy(best, all),
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

results::Claim delay_claim(Touch touch, const ClaimInputs& inputs, const results::BootstrapOptions& options) {
  results::Claim claim = unmeasured(
      fmt::format("{}-delay", name_of(touch)), results::ClaimScope::every_object,
      fmt::format("The mean detection delay of {} is below 5 ms for every object: that of the slowest object", name_of(touch)),
      "The average delay is below 5 ms for press and slip and for all ten objects", "ms", results::Asked::below, 5);
  const results::DelayTable delays = evaluation::delay_table(inputs.detections, touch, options);
  if (delays.objects.empty()) return claim;
  const results::DelayTable wide = evaluation::delay_table(inputs.detections, touch, wide_for(delays.objects.size(), options));
  ObjectFigures figures;
  for (const auto& [object, delay] : delays.objects) figures.objects[object] = delay.mean_ms;
  for (const auto& [object, delay] : wide.objects) figures.wide[object] = delay.mean_ms;
  take(claim, std::move(figures), evaluation::mean_delay_of_these_objects(inputs.detections, touch, options));
  claim.of = claim.objects.size();
  const results::DelaySummary& all = delays.all;
  claim.in_words = std::isnan(claim.measured.value) ? fmt::format("No {} of {} was detected.", name_of(touch), all.intervals)
                                                    : fmt::format("Below 5 ms for {}; the slowest is {} with {:.2f} ms.",
                                                                  kept_of(claim), furthest_object(claim), claim.measured.value);
  if (all.misses + all.early > 0)
    claim.note = fmt::format("Of {} intervals (of {} trainings) {} were missed and {} detected early; they are not in the means.",
                             all.intervals, all.mean_ms.trainings, all.misses, all.early);
  return claim;
}

/// A claim on delays holds only if every interval has one.
void judge_delay(results::Claim& claim) {
  if (claim.outcome != results::Outcome::holds || claim.note.empty()) return;
  claim.outcome = results::Outcome::cannot_tell;
  claim.why = "some intervals have no delay; of the others the claim would hold";
}

/// An object is the only exception only if the others come near.
void judge_exception(results::Claim& exception, const results::Claim& others) {
  if (exception.outcome != results::Outcome::holds || others.outcome == results::Outcome::holds) return;
  exception.outcome = others.outcome;
  exception.why = fmt::format("the others come near: {}", name_of(others.outcome));
}

/// Nothing if the runs have no slip.
std::optional<bool> every_slip_at_once(std::span<const results::RunDetections> runs, std::span<const std::size_t> chosen_runs,
                                       double tick_ms) {
  std::optional<bool> all;
  for (const std::size_t i : chosen_runs) {
    for (const results::Detection& detection : runs[i].detections) {
      if (detection.interval.touch != Touch::slip) continue;
      const bool at_once = detection.outcome == results::DetectionOutcome::detected &&
                           static_cast<double>(detection.delay.count()) <= 1000 * tick_ms * (1 + 1e-9);
      all = all.value_or(true) && at_once;
    }
  }
  return all;
}

results::Claim slip_at_once(const ClaimInputs& inputs, const results::BootstrapOptions& options) {
  results::Claim claim = unmeasured(
      "slip-at-once", results::ClaimScope::over_objects,
      "For most objects slip is detected at once: the share of objects whose slips were all detected at their first tick",
      "In six of ten objects slip is detected with minimal delay in all trials", "%", results::Asked::above, 50);
  const std::span<const results::RunDetections> runs(inputs.detections);
  const auto objects = evaluation::results_by_object(runs, [](const results::RunDetections& run) {
    return std::any_of(run.detections.begin(), run.detections.end(),
                       [](const results::Detection& detection) { return detection.interval.touch == Touch::slip; });
  });
  if (objects.empty()) return claim;
  claim.kept = 0;
  claim.of = objects.size();
  std::set<std::size_t> trainings;
  for (const auto& object : objects) {
    *claim.kept += every_slip_at_once(runs, evaluation::indexes_of(object.second), inputs.tick_ms) == true ? 1U : 0U;
    for (const evaluation::CrossedCell& cell : object.second) trainings.insert(cell.training);
  }
  // Each object has all or nothing of it, over all trainings.
  const auto [low, high] = evaluation::binomial_bounds(*claim.kept, *claim.of, options.confidence);
  claim.measured = {.value = 100 * static_cast<double>(*claim.kept) / static_cast<double>(*claim.of),
                    .low = 100 * low,
                    .high = 100 * high,
                    .n = *claim.of,
                    .trainings = trainings.size()};
  claim.in_words = fmt::format("Every slip was detected at its first tick for {}.", kept_of(claim));
  return claim;
}

results::Claim right_at_first(const ClaimInputs& inputs) {
  results::Claim claim = unmeasured("right-at-first", results::ClaimScope::over_objects,
                                    "In the first 500 ms of a press or slip the verdicts are correct: the share of correct ticks",
                                    "During the beginning of pressing and slippage the classification is highly accurate", "%",
                                    results::Asked::above, 95);
  claim.measured = scaled(inputs.over_time.first, 100);
  claim.in_words = fmt::format("{:.2f} % of the ticks in the first 500 ms are correct, the mean over {} objects.",
                               claim.measured.value, claim.measured.n);
  return claim;
}

results::Claim worse_near_the_end(const ClaimInputs& inputs) {
  results::Claim claim = unmeasured(
      "worse-near-the-end", results::ClaimScope::over_objects,
      "Near the end of a press or slip verdicts are worse: the share of correct ticks in the last 200 ms, minus that before in "
      "the same interval",
      "Near the end of each incident the model deviates from the ground truth", "points", results::Asked::below, 0);
  const results::ShareOverTime& over_time = inputs.over_time;
  claim.measured = scaled(over_time.last_minus_before, 100);
  const std::uint64_t compared = over_time.intervals - std::min(over_time.intervals, over_time.short_ones);
  claim.in_words = fmt::format(
      "In the last 200 ms the share of correct ticks is {:.2f} points {} than before: the mean over {} objects, {} of {} "
      "intervals; {} have no tick before and are left out.",
      std::abs(claim.measured.value), claim.measured.value < 0 ? "lower" : "higher", claim.measured.n, compared,
      over_time.intervals, over_time.short_ones);
  if (std::isfinite(over_time.still_predicted.value)) {
    claim.note = fmt::format(
        "The paper's first reason is the time after the end: in the {:g} ms after an interval {:.1f} % of the ticks are still "
        "predicted as press or slip. Part of that is t_h itself, which looks {:g} ms back.",
        inputs.after_ms, 100 * over_time.still_predicted.value, inputs.history_ms);
  }
  return claim;
}

results::Claim unseen_near_seen(const ClaimInputs& inputs, const results::BootstrapOptions& options) {
  results::Claim claim = unmeasured(
      "unseen-near-seen", results::ClaimScope::every_object,
      fmt::format("Unseen objects but {} come near seen ones: without them in training, accuracy drops by less than 5 points "
                  "for each; the figure is that of the object that loses most",
                  exception_object),
      "For most unseen objects the accuracy is comparable to that with the objects in training", "points", results::Asked::above,
      -near_points);
  if (inputs.seen.empty()) return claim;
  std::vector<results::RunConfusion> seen, held_out;
  for (std::size_t i = 0; i < inputs.seen.size() && i < inputs.held_out.size(); ++i) {
    if (inputs.seen[i].object == exception_object && inputs.held_out[i].object == exception_object) continue;
    seen.push_back(inputs.seen[i]);
    held_out.push_back(inputs.held_out[i]);
  }
  const auto objects = evaluation::results_by_object(std::span<const results::RunConfusion>(seen), has_samples);
  if (objects.empty()) return claim;
  take(
      claim, objects,
      [&](std::span<const std::size_t> runs) { return 100 * (accuracy_over(held_out, runs) - accuracy_over(seen, runs)); },
      {-100, 100, 100 * evaluation::range_of_shares(seen).step}, options);
  claim.in_words = fmt::format("Less than 5 points are lost for {}; {} {} {:.2f} points.", kept_of(claim), furthest_object(claim),
                               claim.measured.value < 0 ? "loses most," : "gains least,", std::abs(claim.measured.value));
  claim.note = fmt::format("The mean over these objects changes by {:+.2f} points.", claim.mean.value);
  return claim;
}

results::Claim unseen_exception(const ClaimInputs& inputs, const results::BootstrapOptions& options) {
  results::Claim claim = unmeasured(
      fmt::format("unseen-{}", exception_object), results::ClaimScope::one_object,
      fmt::format("{} is the exception: without it in training, accuracy drops by more than 5 points", exception_object),
      "The only exception is the plastic container, where the accuracy was significantly lower", "points", results::Asked::below,
      -near_points);
  if (inputs.seen.empty()) return claim;
  const auto differences = evaluation::accuracy_difference(inputs.seen, inputs.held_out, options).objects;
  const auto found = differences.find(exception_object);
  if (found == differences.end()) return claim;
  claim.measured = scaled(found->second, 100);
  claim.in_words = fmt::format("Without it in training {} {} {:.2f} points.", exception_object,
                               claim.measured.value < 0 ? "loses" : "gains", std::abs(claim.measured.value));
  return claim;
}

}  // namespace

std::vector<results::Claim> claims_of(const ClaimInputs& inputs, const results::BootstrapOptions& options) {
  const Histories histories(inputs.histories);
  std::vector<results::Claim> claims{history_2_worst(histories, options),
                                     best_history_40(histories, options),
                                     marginal_past_20(histories, options),
                                     accuracy_at_40(histories, options),
                                     delay_claim(Touch::press, inputs, options),
                                     delay_claim(Touch::slip, inputs, options),
                                     slip_at_once(inputs, options),
                                     right_at_first(inputs),
                                     worse_near_the_end(inputs),
                                     unseen_near_seen(inputs, options),
                                     unseen_exception(inputs, options)};
  for (results::Claim& claim : claims) judge(claim);
  // One history can disprove a claim about histories; to prove it takes all.
  for (std::size_t i = 0; i < 3 && !inputs.untrained.empty(); ++i) {
    if (claims[i].outcome != results::Outcome::holds) continue;
    std::vector<std::string> lacking;
    for (const microseconds history : inputs.untrained) lacking.push_back(experiments::ms_text(history));
    claims[i].outcome = results::Outcome::cannot_tell;
    claims[i].why = fmt::format("no model was trained for {} ms, which the paper compares", fmt::join(lacking, ", "));
    claims[i].can_be_decided = false;
  }
  for (const std::size_t delay : {4U, 5U}) judge_delay(claims[delay]);
  judge_exception(claims[10], claims[9]);
  return claims;
}

std::string summary_of(const std::vector<results::Claim>& claims, bool simulated) {
  const auto number_of = [&](results::Outcome outcome) {
    return std::count_if(claims.begin(), claims.end(), [&](const results::Claim& claim) { return claim.outcome == outcome; });
  };
  const auto undecidable =
      std::count_if(claims.begin(), claims.end(), [](const results::Claim& claim) { return !claim.can_be_decided; });
  std::string text = fmt::format("On {} runs {} of the paper's {} claims hold, {} do not, and {} cannot be decided",
                                 simulated ? "simulated" : "real", number_of(results::Outcome::holds), claims.size(),
                                 number_of(results::Outcome::does_not), number_of(results::Outcome::cannot_tell));
  if (undecidable > 0) text += fmt::format(": for {} of them there are too few trainings, runs or objects", undecidable);
  return text + ".";
}

}  // namespace tactile::study
