#include "tactile/experiments/study/claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "tactile/experiments/study/claim_figures.hpp"
#include "tactile/experiments/study/history_claims.hpp"
#include "tactile/experiments/study/unseen_claims.hpp"

namespace tactile::study {
namespace {

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
  claim.measured = {.value = 100 * static_cast<double>(*claim.kept) / static_cast<double>(*claim.of),
                    .n = *claim.of,
                    .trainings = trainings.size()};
  if (evaluation::allows_bounds(objects.size(), trainings.size())) {
    // Each object has all or nothing of it, over all trainings.
    const auto [low, high] =
        evaluation::binomial_bounds(static_cast<double>(*claim.kept), static_cast<double>(*claim.of), options.confidence);
    claim.measured.low = 100 * low;
    claim.measured.high = 100 * high;
  }
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

}  // namespace

std::vector<results::Claim> claims_of(const ClaimInputs& inputs, const results::BootstrapOptions& options) {
  std::vector<results::Claim> claims = history_claims(inputs, options);
  for (const Touch touch : {Touch::press, Touch::slip}) {
    claims.push_back(delay_claim(touch, inputs, options));
    judge(claims.back());
    judge_delay(claims.back());
  }
  for (results::Claim& claim : std::array{slip_at_once(inputs, options), right_at_first(inputs), worse_near_the_end(inputs)}) {
    judge(claim);
    claims.push_back(std::move(claim));
  }
  for (results::Claim& claim : unseen_claims(inputs, options)) claims.push_back(std::move(claim));
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
