#include "tactile/experiments/study/unseen_claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>

#include "tactile/experiments/study/claim_figures.hpp"

namespace tactile::study {
namespace {

constexpr const char* exception_object = "plastic-container";
constexpr double near_points = 5;        ///< taken for "comparable"
constexpr double accurate_percent = 95;  ///< taken for "highly accurate"

/// The same runs judged with and without their objects in training.
struct Compared {
  std::vector<results::RunConfusion> seen, held_out;
};

Compared without_the_exception(const ClaimInputs& inputs) {
  Compared others;
  for (std::size_t i = 0; i < inputs.seen.size() && i < inputs.held_out.size(); ++i) {
    if (inputs.seen[i].object == exception_object && inputs.held_out[i].object == exception_object) continue;
    others.seen.push_back(inputs.seen[i]);
    others.held_out.push_back(inputs.held_out[i]);
  }
  return others;
}

double percent_of(const std::vector<results::RunConfusion>& all, std::span<const std::size_t> runs) {
  return 100 * evaluation::accuracy_over(all, runs).value_or(NAN);
}

/// @param changes  of the accuracy without the objects in training
results::Claim seen_better(const results::Accuracy& changes) {
  results::Claim claim =
      unmeasured("seen-better", results::ClaimScope::over_objects,
                 "Objects in training are classified better: the mean accuracy with them in training minus that without",
                 "The model generally provides a better performance when the data from an object is included in the training set",
                 "points", results::Asked::above, 0);
  if (changes.objects.empty()) return claim;
  claim.measured = scaled(changes.mean, -100);
  claim.of = changes.objects.size();
  claim.kept = static_cast<std::size_t>(
      std::count_if(changes.objects.begin(), changes.objects.end(), [](const auto& object) { return object.second.value < 0; }));
  claim.in_words =
      fmt::format("In training {} are classified better; the mean gains {:.2f} points.", kept_of(claim), claim.measured.value);
  return claim;
}

results::Claim unseen_near_seen(const Compared& others, const results::BootstrapOptions& options) {
  results::Claim claim = unmeasured(
      "unseen-near-seen", results::ClaimScope::every_object,
      fmt::format("Unseen objects but {} come near seen ones: without them in training, accuracy drops by less than 5 points "
                  "for each; the figure is that of the object that loses most",
                  exception_object),
      "For most unseen objects the accuracy is comparable to that with the objects in training", "points", results::Asked::above,
      -near_points);
  const auto objects =
      evaluation::results_by_object(std::span<const results::RunConfusion>(others.seen), evaluation::has_samples);
  if (objects.empty()) return claim;
  take(
      claim, objects,
      [&](std::span<const std::size_t> runs) { return percent_of(others.held_out, runs) - percent_of(others.seen, runs); },
      {-100, 100, 100 * evaluation::range_of_shares(others.seen).step}, options);
  claim.in_words = fmt::format("Less than 5 points are lost for {}; {} {} {:.2f} points.", kept_of(claim), furthest_object(claim),
                               claim.measured.value < 0 ? "loses most," : "gains least,", std::abs(claim.measured.value));
  claim.note = fmt::format("The mean over these objects changes by {:+.2f} points.", claim.mean.value);
  return claim;
}

results::Claim unseen_accurate(const Compared& others, const results::BootstrapOptions& options) {
  results::Claim claim = unmeasured(
      "unseen-accurate", results::ClaimScope::every_object,
      fmt::format("Unseen objects but {} are classified accurately: above 95 % for each; the figure is that of the lowest object",
                  exception_object),
      "For most unseen objects the model delivers highly accurate classifications", "%", results::Asked::above, accurate_percent);
  const auto objects =
      evaluation::results_by_object(std::span<const results::RunConfusion>(others.held_out), evaluation::has_samples);
  if (objects.empty()) return claim;
  take(
      claim, objects, [&](std::span<const std::size_t> runs) { return percent_of(others.held_out, runs); },
      {0, 100, 100 * evaluation::range_of_shares(others.held_out).step}, options);
  claim.in_words = fmt::format("Above 95 % for {}; the lowest is {} with {:.2f} %.", kept_of(claim), furthest_object(claim),
                               claim.measured.value);
  claim.note = "The paper names 95 % for objects in training; here it is taken for \"highly accurate\".";
  return claim;
}

results::Claim unseen_exception(const results::Accuracy& changes) {
  results::Claim claim = unmeasured(
      fmt::format("unseen-{}", exception_object), results::ClaimScope::one_object,
      fmt::format("{} is the exception: without it in training, accuracy drops by more than 5 points", exception_object),
      "The only exception is the plastic container, where the accuracy was significantly lower", "points", results::Asked::below,
      -near_points);
  const auto found = changes.objects.find(exception_object);
  if (found == changes.objects.end()) return claim;
  claim.measured = scaled(found->second, 100);
  claim.in_words = fmt::format("Without it in training {} {} {:.2f} points.", exception_object,
                               claim.measured.value < 0 ? "loses" : "gains", std::abs(claim.measured.value));
  return claim;
}

/// An object is the only exception only if the others come near.
void judge_exception(results::Claim& exception, const results::Claim& others) {
  if (exception.outcome != results::Outcome::holds || others.outcome == results::Outcome::holds) return;
  exception.outcome = others.outcome;
  exception.why = fmt::format("the others come near: {}", name_of(others.outcome));
}

}  // namespace

std::vector<results::Claim> unseen_claims(const ClaimInputs& inputs, const results::BootstrapOptions& options) {
  const Compared others = without_the_exception(inputs);
  results::Accuracy changes;
  if (!inputs.seen.empty()) changes = evaluation::accuracy_difference(inputs.seen, inputs.held_out, options);
  std::vector<results::Claim> claims{seen_better(changes), unseen_near_seen(others, options), unseen_accurate(others, options),
                                     unseen_exception(changes)};
  for (results::Claim& claim : claims) judge(claim);
  judge_exception(claims[3], claims[1]);
  return claims;
}

}  // namespace tactile::study
