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

/// What a verdict lacks, in words; empty if nothing.
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

/// What would decide a claim at the values seen, by the figure that is furthest from deciding:
///
///   factor = ((bound - value) / (value - limit))^2, of the bound beyond the limit
std::string enough_of(const results::Claim& claim) {
  constexpr double most = 20;
  const results::Figure& measured = claim.measured;
  const bool is_refuted = claim.asked == results::Asked::below ? measured.value > claim.limit : measured.value < claim.limit;
  double factor = 0;
  std::size_t n = measured.n;
  const auto take = [&](const results::Figure& figure) {
    const double effect = figure.value - claim.limit;
    const std::optional<double>& bound = effect < 0 ? figure.high : figure.low;
    const bool is_across = bound && (effect < 0 ? *bound >= claim.limit : *bound <= claim.limit);
    if (!is_across || figure.n < 2) return;
    const double of_figure = effect == 0 ? INFINITY : std::pow((*bound - figure.value) / effect, 2);
    if (of_figure > factor) factor = of_figure, n = figure.n;
  };
  double confidence = 0.95;
  if (claim.scope != results::ClaimScope::every_object) {
    take(measured);
  } else if (is_refuted) {
    // One object beyond the limit is enough, but by the wide interval.
    confidence = 1 - 0.05 / static_cast<double>(claim.objects.size());
    results::Figure outermost = measured;
    for (const auto& object : claim.objects) outermost.n = object.second.value == measured.value ? object.second.n : outermost.n;
    take(outermost);
  } else {
    for (const auto& object : claim.objects) take(object.second);
  }
  if (factor <= 1) return "somewhat more trainings and runs would decide";
  if (!(factor <= most)) return fmt::format("the value is so near the limit that {:.0f} times the data would not decide", most);
  return fmt::format("if the value stays, about {} trainings and {} {} would decide",
                     enough_for(factor, measured.trainings, confidence), enough_for(factor, n, confidence),
                     claim.scope == results::ClaimScope::over_objects ? "objects" : "runs of each object");
}

}  // namespace

results::Verdict below(const results::Figure& figure, double limit) {
  if (figure.high && *figure.high < limit) return results::Verdict::holds;
  if (figure.low && *figure.low > limit) return results::Verdict::does_not;
  return results::Verdict::cannot_tell;
}

results::Verdict above(const results::Figure& figure, double limit) {
  if (figure.low && *figure.low > limit) return results::Verdict::holds;
  if (figure.high && *figure.high < limit) return results::Verdict::does_not;
  return results::Verdict::cannot_tell;
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
  claim.verdict = claim.asked == results::Asked::below ? below(claim.measured, claim.limit) : above(claim.measured, claim.limit);
  if (!lacking.empty() && (claim.scope == results::ClaimScope::over_objects || claim.measured.trainings < fewest_trainings))
    claim.verdict = results::Verdict::cannot_tell;
  claim.can_be_told = lacking.empty() || claim.verdict != results::Verdict::cannot_tell;
  if (claim.verdict != results::Verdict::cannot_tell) return;
  const bool is_bounded = claim.measured.has_interval();
  claim.why = !lacking.empty() ? lacking
              : is_bounded     ? "the interval lies across the limit; " + enough_of(claim)
                               : std::string("no interval: too few runs or objects have something to measure");
}

}  // namespace tactile::study
