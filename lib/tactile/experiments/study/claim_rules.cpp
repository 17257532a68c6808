#include "tactile/experiments/study/claim_rules.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "tactile/evaluation/crossed_figure.hpp"

namespace tactile::study {
namespace {

/// What is missing to decide, in words; empty if nothing.
std::string too_few(const results::Claim& claim) {
  if (claim.measured.trainings < fewest_trainings)
    return fmt::format("too few trainings: {}, {} needed", claim.measured.trainings, fewest_trainings);
  if (claim.scope == results::ClaimScope::over_objects) {
    return claim.measured.n >= fewest_objects ? std::string()
                                              : fmt::format("too few objects: {}, {} needed", claim.measured.n, fewest_objects);
  }
  if (claim.scope == results::ClaimScope::one_object) {
    return claim.measured.n >= fewest_runs ? std::string()
                                           : fmt::format("too few runs: {}, {} needed", claim.measured.n, fewest_runs);
  }
  std::vector<std::string> short_of;
  std::set<std::size_t> counts;
  for (const auto& [name, figure] : claim.objects) {
    if (figure.n >= fewest_runs) continue;
    short_of.push_back(name);
    counts.insert(figure.n);
  }
  if (short_of.empty()) return {};
  const std::string count =
      counts.size() == 1 ? fmt::format("{}", *counts.begin()) : fmt::format("{} to {}", *counts.begin(), *counts.rbegin());
  return short_of.size() == claim.objects.size()
             ? fmt::format("too few runs: {} each, {} needed", count, fewest_runs)
             : fmt::format("too few runs of {}: {}, {} needed of each object", fmt::join(short_of, ", "), count, fewest_runs);
}

results::Figure outermost_of(const ObjectFigures& figures, const std::function<bool(double, double)>& further,
                             std::optional<double> results::Figure::*inner, std::optional<double> results::Figure::*outer) {
  results::Figure result;
  bool all_known = true;
  const auto take_further = [&](std::optional<double>& bound, const std::optional<double>& other) {
    if (other && (!bound || further(*other, *bound))) bound = other;
  };
  for (const auto& [name, figure] : figures.wide) take_further(result.*inner, figure.*inner);
  for (const auto& [name, figure] : figures.objects) {
    if (std::isnan(figure.value)) {
      all_known = false;
      continue;
    }
    result.trainings = result.n == 0 ? figure.trainings : std::min(result.trainings, figure.trainings);
    ++result.n;
    if (std::isnan(result.value) || further(figure.value, result.value)) result.value = figure.value;
    if (!(figure.*outer)) all_known = false;
    take_further(result.*outer, figure.*outer);
  }
  if (!all_known) result.*outer = std::nullopt;
  return result;
}

/// How many of `count` would make an interval narrower by the square root of `factor`: the width goes with t(n - 1) / sqrt(n).
std::size_t enough_for(double factor, std::size_t count, double confidence) {
  const auto width = [confidence](std::size_t n) {
    return evaluation::student_quantile(n - 1, confidence) / std::sqrt(static_cast<double>(n));
  };
  const double needed = width(count) / std::sqrt(factor);
  std::size_t enough = count;
  while (width(enough) > needed) ++enough;
  return enough;
}

results::Outcome outcome_of(const results::Claim& claim, const results::Figure& figure) {
  return claim.asked == results::Asked::below ? below(figure, claim.limit) : above(figure, claim.limit);
}

/// How many times narrower, squared, an interval must be to decide: ((bound - value) / (value - limit))^2, of the bound beyond
/// the limit; 0 where it decides, or is unknown.
double factor_of(const results::Figure& figure, double limit) {
  const double effect = figure.value - limit;
  const std::optional<double>& bound = effect < 0 ? figure.high : figure.low;
  const bool is_across = bound && (effect < 0 ? *bound >= limit : *bound <= limit);
  if (!is_across) return 0;
  return effect == 0 ? INFINITY : std::pow((*bound - figure.value) / effect, 2);
}

/// What would decide a claim at the values seen, by the figure that is furthest from deciding; of a claim about every object that
/// seems wrong, by the outermost object or the mean, whichever is nearer to it.
std::string enough_of(const results::Claim& claim) {
  constexpr double most = 20;
  const results::Figure& measured = claim.measured;
  const auto is_refuted = [&](const results::Figure& figure) {
    return claim.asked == results::Asked::below ? figure.value > claim.limit : figure.value < claim.limit;
  };
  double factor = 0, confidence = 0.95;
  std::size_t n = measured.n, parts = 1;  // runs are of this many objects
  if (claim.scope != results::ClaimScope::every_object) {
    factor = factor_of(measured, claim.limit);
  } else if (is_refuted(measured)) {
    // One object beyond the limit is enough, but by the wide interval.
    factor = factor_of(measured, claim.limit);
    confidence = 1 - 0.05 / static_cast<double>(claim.objects.size());
    for (const auto& object : claim.objects) n = object.second.value == measured.value ? object.second.n : n;
    const double of_mean = is_refuted(claim.mean) ? factor_of(claim.mean, claim.limit) : 0;
    if (of_mean > 0 && of_mean < factor) factor = of_mean, confidence = 0.95, n = claim.mean.n, parts = measured.n;
  } else {
    for (const auto& object : claim.objects) {
      const double of_object = factor_of(object.second, claim.limit);
      if (of_object > factor) factor = of_object, n = object.second.n;
    }
  }
  if (factor <= 1 || n < 2) return "somewhat more trainings and runs would decide";
  if (!(factor <= most)) return fmt::format("the value is so near the limit that {:.0f} times the data would not decide", most);
  return fmt::format("if the value stays, about {} trainings and {} {} would decide",
                     enough_for(factor, measured.trainings, confidence), (enough_for(factor, n, confidence) + parts - 1) / parts,
                     claim.scope == results::ClaimScope::over_objects ? "objects" : "runs of each object");
}

}  // namespace

results::Outcome below(const results::Figure& figure, double limit) {
  if (figure.high && *figure.high < limit) return results::Outcome::holds;
  if (figure.low && *figure.low > limit) return results::Outcome::does_not;
  return results::Outcome::cannot_tell;
}

results::Outcome above(const results::Figure& figure, double limit) {
  if (figure.low && *figure.low > limit) return results::Outcome::holds;
  if (figure.high && *figure.high < limit) return results::Outcome::does_not;
  return results::Outcome::cannot_tell;
}

results::Figure largest_of(const ObjectFigures& figures) {
  return outermost_of(
      figures, [](double a, double b) { return a > b; }, &results::Figure::low, &results::Figure::high);
}

results::Figure smallest_of(const ObjectFigures& figures) {
  return outermost_of(
      figures, [](double a, double b) { return a < b; }, &results::Figure::high, &results::Figure::low);
}

void judge(results::Claim& claim) {
  if (std::isnan(claim.measured.value)) {
    claim.in_words.clear();
    claim.note = "Not measured in this study.";
    claim.why = "not measured";
    return;
  }
  const std::string lacking = too_few(claim);
  claim.outcome = outcome_of(claim, claim.measured);
  const bool by_mean =
      claim.outcome == results::Outcome::cannot_tell && outcome_of(claim, claim.mean) == results::Outcome::does_not;
  if (by_mean) claim.outcome = results::Outcome::does_not;
  if (!lacking.empty() && (claim.scope == results::ClaimScope::over_objects || claim.measured.trainings < fewest_trainings))
    claim.outcome = results::Outcome::cannot_tell;
  claim.can_be_decided = lacking.empty() || claim.outcome != results::Outcome::cannot_tell;
  if (by_mean && claim.outcome == results::Outcome::does_not)
    claim.in_words += fmt::format(" It does not hold because of the mean over these {} objects: {}.", claim.measured.n,
                                  results::text_of(claim.mean, " " + claim.unit, ".2f"));
  if (claim.outcome != results::Outcome::cannot_tell) return;
  const bool is_bounded = claim.measured.has_interval();
  claim.why = !lacking.empty() ? lacking
              : is_bounded     ? "the interval lies across the limit; " + enough_of(claim)
                               : std::string("no interval: too few runs or objects have something to measure");
}

}  // namespace tactile::study
