#include "tactile/study/claims.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

constexpr const char* exception_object = "plastic-container";
constexpr double near_points = 5;  ///< what "comparable" is taken to be
constexpr microseconds shortest{2'000}, marginal{20'000}, chosen{40'000};

Figure scaled(Figure figure, double factor) {
  figure.value *= factor;
  if (figure.low) *figure.low *= factor;
  if (figure.high) *figure.high *= factor;
  return figure;
}

std::map<std::string, Figure> scaled(std::map<std::string, Figure> figures, double factor) {
  for (auto& [name, figure] : figures) figure = scaled(figure, factor);
  return figures;
}

Claim unmeasured(std::string id, std::string claim, std::string paper, std::string unit, Asked asked, double limit) {
  Claim empty;
  empty.id = std::move(id);
  empty.claim = std::move(claim);
  empty.paper = std::move(paper);
  empty.unit = std::move(unit);
  empty.asked = asked;
  empty.limit = limit;
  return empty;
}

/// Accuracies of the same runs at every history.
class Histories {
 public:
  explicit Histories(const std::map<microseconds, std::vector<RunConfusion>>& histories) : histories_(histories) {
    for (const auto& [history, runs] : histories_) {
      const auto& first = histories_.begin()->second;
      const bool same = std::equal(runs.begin(), runs.end(), first.begin(), first.end(),
                                   [](const RunConfusion& a, const RunConfusion& b) { return a.object == b.object; });
      if (!same) throw Error("accuracies of histories on different runs; expected the same runs for each");
    }
    if (!histories_.empty()) {
      const auto has_samples = [](const RunConfusion& run) { return run.confusion.samples() > 0; };
      objects_ = runs_by_object(std::span<const RunConfusion>(histories_.begin()->second), has_samples);
    }
  }

  bool has(microseconds history) const { return histories_.contains(history); }
  bool has_others(microseconds history) const { return has(history) && histories_.size() > 1; }
  const std::map<std::string, std::vector<std::size_t>>& objects() const { return objects_; }

  double accuracy(microseconds history, std::span<const std::size_t> runs) const {
    Confusion sum;
    for (const std::size_t run : runs) sum += histories_.at(history)[run].confusion;
    return sum.accuracy().value_or(NAN);
  }

  double mean_accuracy(microseconds history, const RunsByObject& objects) const {
    double sum = 0;
    for (const auto& runs : objects) sum += accuracy(history, runs);
    return sum / static_cast<double>(objects.size());
  }

  /// The shorter of equals.
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
  const std::map<microseconds, std::vector<RunConfusion>>& histories_;
  std::map<std::string, std::vector<std::size_t>> objects_;
};

Claim history_2_worst(const Histories& histories, const BootstrapOptions& options) {
  Claim claim = unmeasured(
      "history-2-worst",
      "A history of 2 ms is the worst for every object: its accuracy less the lowest at any other history, of the object "
      "where that is largest",
      "Instantaneous heatmaps (2 ms) are worst for all ten objects", "points", Asked::below, 0);
  if (!histories.has_others(shortest)) return claim;
  const auto others = histories.those([](microseconds history) { return history != shortest; });
  for (const auto& [object, runs] : histories.objects()) {
    claim.objects[object] = figure_of_object(
        runs,
        [&](const RunsByObject& drawn) -> std::optional<double> {
          double lowest = 1;
          for (const microseconds other : others) lowest = std::min(lowest, histories.accuracy(other, drawn.front()));
          return 100 * (histories.accuracy(shortest, drawn.front()) - lowest);
        },
        options);
  }
  claim.measured = largest_of(claim.objects);
  return claim;
}

Claim best_history_40(const Histories& histories, const BootstrapOptions& options) {
  Claim claim = unmeasured(
      "best-history-40", "A history of 40 ms is the best for more objects than any other: their number less that of the next one",
      "40 ms is the best for five objects, 50 ms for three, 20 ms for two", "objects", Asked::above, 0);
  if (!histories.has_others(chosen)) return claim;
  std::map<microseconds, std::size_t> counts;
  for (const auto& object : histories.objects()) ++counts[histories.best(object.second)];
  const Statistic lead = [&](const RunsByObject& objects) -> std::optional<double> {
    std::map<microseconds, int> best;
    for (const auto& runs : objects) ++best[histories.best(runs)];
    int next = 0;
    for (const auto& [history, count] : best) {
      if (history != chosen) next = std::max(next, count);
    }
    return best[chosen] - next;
  };
  claim.measured = figure_over_objects(without_names(histories.objects()), lead, options);
  for (const auto& [history, count] : counts)
    claim.note += fmt::format("{}{} ms is the best for {}", claim.note.empty() ? "" : ", ",
                              static_cast<double>(history.count()) / 1000, count);
  if (!claim.note.empty()) claim.note += fmt::format(" of {} objects (the shorter of equals).", histories.objects().size());
  return claim;
}

Claim marginal_past_20(const Histories& histories, const BootstrapOptions& options) {
  Claim claim =
      unmeasured("marginal-past-20",
                 "Past 20 ms a longer history gains less than a point: the highest mean accuracy past 20 ms less that at 20 ms",
                 "Improvements become marginal after 20 ms", "points", Asked::below, 1);
  const auto longer = histories.those([](microseconds history) { return history > marginal; });
  if (!histories.has(marginal) || longer.empty()) return claim;
  claim.measured = figure_over_objects(
      without_names(histories.objects()),
      [&](const RunsByObject& objects) -> std::optional<double> {
        double highest = 0;
        for (const microseconds history : longer) highest = std::max(highest, histories.mean_accuracy(history, objects));
        return 100 * (highest - histories.mean_accuracy(marginal, objects));
      },
      options);
  return claim;
}

Claim accuracy_at_40(const ClaimInputs& inputs, const BootstrapOptions& options) {
  Claim claim = unmeasured("accuracy-at-40", "With 40 ms the accuracy is above 95 % for every object: that of the lowest object",
                           "The average accuracy of the nine test runs exceeds 95 % for all ten objects", "%", Asked::above, 95);
  const auto found = inputs.histories.find(chosen);
  if (found == inputs.histories.end()) return claim;
  claim.objects = scaled(accuracy_of(found->second, options).objects, 100);
  claim.measured = smallest_of(claim.objects);
  return claim;
}

Claim delay_claim(const std::string& touch, const std::map<std::string, ObjectDelays>& delays) {
  Claim claim =
      unmeasured(touch + "-delay",
                 fmt::format("The mean detection delay of {} is below 5 ms for every object: that of the slowest object", touch),
                 "The average delay is below 5 ms for press and slip and for all ten objects", "ms", Asked::below, 5);
  std::uint64_t intervals = 0, misses = 0, early = 0;
  for (const auto& [object, delay] : delays) {
    claim.objects[object] = delay.mean_ms;
    intervals += delay.intervals;
    misses += delay.misses;
    early += delay.early;
  }
  if (delays.empty()) return claim;
  claim.measured = largest_of(claim.objects);
  if (misses + early > 0)
    claim.note =
        fmt::format("Of {} intervals {} were missed and {} told early; they are not in the means.", intervals, misses, early);
  return claim;
}

/// A delay holds only where every interval had one.
void judge_delay(Claim& claim, const std::map<std::string, ObjectDelays>& delays) {
  const bool all_detected = std::all_of(delays.begin(), delays.end(),
                                        [](const auto& object) { return object.second.misses + object.second.early == 0; });
  if (claim.verdict == Verdict::holds && !all_detected) {
    claim.verdict = Verdict::cannot_tell;
    claim.note += " Without them the claim would hold.";
  }
}

Claim slip_at_once(const ClaimInputs& inputs, const BootstrapOptions& options) {
  Claim claim = unmeasured(
      "slip-at-once",
      "In most objects slip is told at the first moment: the share of objects in which every slip was told at its first tick",
      "In six of ten objects slip is detected with minimal delay in all trials", "%", Asked::above, 50);
  std::vector<double> at_once;
  RunsByObject objects;
  for (const auto& [object, delay] : inputs.slip) {
    if (delay.intervals == 0) continue;
    objects.push_back({at_once.size()});
    const bool all = delay.misses + delay.early == 0 && delay.mean_ms.value <= inputs.tick_ms * (1 + 1e-9);
    at_once.push_back(all ? 100 : 0);
  }
  claim.measured = figure_over_objects(
      objects, mean_over_objects([&](std::span<const std::size_t> object) { return at_once[object.front()]; }), options);
  return claim;
}

Claim right_at_first(const ClaimInputs& inputs) {
  Claim claim =
      unmeasured("right-at-first", "In the first 500 ms of a press or slip verdicts are right: the share of ticks said right",
                 "During the beginning of pressing and slippage the classification is highly accurate", "%", Asked::above, 95);
  claim.measured = scaled(inputs.first, 100);
  return claim;
}

Claim worse_near_the_end(const ClaimInputs& inputs) {
  Claim claim = unmeasured(
      "worse-near-the-end",
      "Near the end of a press or slip verdicts are worse: the share of ticks said right in the last 200 ms, less that in the "
      "first 500 ms",
      "Near the end of each incident the model deviates from the ground truth", "points", Asked::below, 0);
  claim.measured = scaled(inputs.last_minus_first, 100);
  return claim;
}

Claim unseen_near_seen(const ClaimInputs& inputs, const BootstrapOptions& options) {
  Claim claim = unmeasured(
      "unseen-near-seen",
      fmt::format("Unseen objects but {} come near seen ones: what accuracy loses without them in training is less than "
                  "5 points, the mean over these objects",
                  exception_object),
      "For most unseen objects the accuracy is comparable to that with the objects in training", "points", Asked::above,
      -near_points);
  if (inputs.seen.empty()) return claim;
  std::vector<RunConfusion> seen, held_out;
  for (std::size_t i = 0; i < inputs.seen.size() && i < inputs.held_out.size(); ++i) {
    if (inputs.seen[i].object == exception_object && inputs.held_out[i].object == exception_object) continue;
    seen.push_back(inputs.seen[i]);
    held_out.push_back(inputs.held_out[i]);
  }
  const Accuracy difference = accuracy_difference(seen, held_out, options);
  claim.measured = scaled(difference.mean, 100);
  claim.objects = scaled(difference.objects, 100);
  return claim;
}

Claim unseen_exception(const ClaimInputs& inputs, const BootstrapOptions& options) {
  Claim claim = unmeasured(
      fmt::format("unseen-{}", exception_object),
      fmt::format("{} is the exception: what accuracy loses without it in training is more than 5 points", exception_object),
      "The only exception is the plastic container, where the accuracy was significantly lower", "points", Asked::below,
      -near_points);
  if (inputs.seen.empty()) return claim;
  const auto differences = accuracy_difference(inputs.seen, inputs.held_out, options).objects;
  if (const auto found = differences.find(exception_object); found != differences.end())
    claim.measured = scaled(found->second, 100);
  return claim;
}

Figure outermost_of(const std::map<std::string, Figure>& objects, const std::function<bool(double, double)>& further,
                    std::optional<double> Figure::*inner, std::optional<double> Figure::*outer) {
  Figure result;
  bool all_known = true;
  for (const auto& [name, figure] : objects) {
    if (std::isnan(figure.value)) {
      all_known = false;
      continue;
    }
    ++result.n;
    if (std::isnan(result.value) || further(figure.value, result.value)) result.value = figure.value;
    if (figure.*inner && (!(result.*inner) || further(*(figure.*inner), *(result.*inner)))) result.*inner = figure.*inner;
    if (!(figure.*outer)) all_known = false;
    if (figure.*outer && (!(result.*outer) || further(*(figure.*outer), *(result.*outer)))) result.*outer = figure.*outer;
  }
  if (!all_known) result.*outer = std::nullopt;
  return result;
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::holds:
      return "holds";
    case Verdict::does_not:
      return "does not";
    case Verdict::cannot_tell:
      return "cannot tell";
  }
  return "cannot tell";
}

Verdict below(const Figure& figure, double limit) {
  if (figure.high && *figure.high < limit) return Verdict::holds;
  if (figure.low && *figure.low >= limit) return Verdict::does_not;
  return Verdict::cannot_tell;
}

Verdict above(const Figure& figure, double limit) {
  if (figure.low && *figure.low > limit) return Verdict::holds;
  if (figure.high && *figure.high <= limit) return Verdict::does_not;
  return Verdict::cannot_tell;
}

Figure largest_of(const std::map<std::string, Figure>& objects) {
  return outermost_of(
      objects, [](double a, double b) { return a > b; }, &Figure::low, &Figure::high);
}

Figure smallest_of(const std::map<std::string, Figure>& objects) {
  return outermost_of(
      objects, [](double a, double b) { return a < b; }, &Figure::high, &Figure::low);
}

void to_json(nlohmann::json& json, const Claim& claim) {
  json = {{"id", claim.id},
          {"claim", claim.claim},
          {"paper", claim.paper},
          {"unit", claim.unit},
          {"asked", claim.asked == Asked::below ? "below" : "above"},
          {"limit", claim.limit},
          {"measured", claim.measured},
          {"objects", claim.objects},
          {"verdict", name_of(claim.verdict)},
          {"note", claim.note}};
}

std::vector<Claim> claims_of(const ClaimInputs& inputs, const BootstrapOptions& options) {
  const Histories histories(inputs.histories);
  std::vector<Claim> claims{history_2_worst(histories, options),  best_history_40(histories, options),
                            marginal_past_20(histories, options), accuracy_at_40(inputs, options),
                            delay_claim("press", inputs.press),   delay_claim("slip", inputs.slip),
                            slip_at_once(inputs, options),        right_at_first(inputs),
                            worse_near_the_end(inputs),           unseen_near_seen(inputs, options),
                            unseen_exception(inputs, options)};
  for (Claim& claim : claims) {
    claim.verdict = claim.asked == Asked::below ? below(claim.measured, claim.limit) : above(claim.measured, claim.limit);
    if (std::isnan(claim.measured.value)) claim.note = "Not measured in this study.";
  }
  judge_delay(claims[4], inputs.press);
  judge_delay(claims[5], inputs.slip);
  return claims;
}

std::string summary_of(const std::vector<Claim>& claims, bool simulated) {
  const auto number_of = [&](Verdict verdict) {
    return std::count_if(claims.begin(), claims.end(), [&](const Claim& claim) { return claim.verdict == verdict; });
  };
  return fmt::format("On {} runs {} of the paper's {} claims hold, {} do not, and of {} one cannot tell.",
                     simulated ? "simulated" : "real", number_of(Verdict::holds), claims.size(), number_of(Verdict::does_not),
                     number_of(Verdict::cannot_tell));
}

}  // namespace tactile
