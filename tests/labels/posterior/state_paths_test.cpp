#include "tactile/labels/posterior/state_paths.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "labels/posterior/dense_transitions.hpp"

namespace tactile::labels {
namespace {

/// Evidence that differs from bin to bin, of some ten nats.
std::vector<double> drawn_evidence(std::size_t bins, std::size_t width, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> evidence(bins * width);
  for (std::size_t i = 0; i < evidence.size(); ++i) evidence[i] = i % width == 0 ? 0 : random.normal() * 3;
  return evidence;
}

/// Conditions of an arm that begins to move and stops.
std::vector<std::uint8_t> moving_arm(std::size_t bins) {
  std::vector<std::uint8_t> conditions(bins, arm_still);
  for (std::size_t b = bins / 3; b < 2 * bins / 3; ++b) conditions[b] = static_cast<std::uint8_t>(1 + b % arm_speeds.size());
  for (std::size_t b = 2 * bins / 3; b < bins; ++b) conditions[b] = arm_stopped;
  return conditions;
}

/// The forward and the backward pass over all states, in long double, without leaving any out.
struct Dense {
  long double log_evidence = 0;
  std::vector<std::vector<long double>> smoothed;  ///< [bin][state]

  Dense(const RunStates& states, const BinLikelihoods& likelihoods, const std::vector<std::uint8_t>& arm, double begins_untouched,
        double begins_otherwise) {
    const std::size_t count = states.count(), bins = likelihoods.bins();
    const auto likelihood = [&](std::size_t b, std::size_t s) {
      long double p = likelihoods.at(b)[BinLikelihoods::class_of(states.happening_of(s), states.level_of(s, arm[b]))];
      const bool moves = arm[b] != arm_still && arm[b] != arm_stopped;
      const bool moved = b > 0 && arm[b - 1] != arm_still && arm[b - 1] != arm_stopped;
      if (b > 0 && moves && !moved) {
        const Happening happening = states.happening_of(s);
        if (happening == Happening::untouched)
          p *= begins_untouched;
        else if (happening != Happening::held && happening != Happening::carried)
          p *= begins_otherwise;
      }
      return p;
    };
    const auto matrix = [&](std::size_t b) {
      std::vector<long double> all(count * count, 0.0L);
      const auto dense = test::dense_transitions(states, arm[b]);
      for (std::size_t s = 0; s < count; ++s)
        std::copy(dense[s].begin(), dense[s].end(), all.begin() + static_cast<std::ptrdiff_t>(s * count));
      return all;
    };
    std::vector<std::vector<long double>> forward(bins, std::vector<long double>(count, 0.0L));
    std::vector<long double> backward(count, 1.0L);
    for (std::size_t b = 0; b < bins; ++b) {
      const auto moves = b > 0 ? matrix(b) : std::vector<long double>();
      long double sum = 0;
      for (std::size_t s = 0; s < count; ++s) {
        long double p = b == 0 ? static_cast<long double>(states.at_start()[s]) : 0.0L;
        for (std::size_t from = 0; b > 0 && from < count; ++from) p += forward[b - 1][from] * moves[from * count + s];
        forward[b][s] = p * likelihood(b, s);
        sum += forward[b][s];
      }
      for (long double& p : forward[b]) p /= sum;
      log_evidence += std::log(sum) + static_cast<long double>(likelihoods.log_largest(b));
    }
    smoothed = forward;
    for (std::size_t b = bins - 1; b > 0; --b) {
      const auto moves = matrix(b);
      std::vector<long double> before(count, 0.0L);
      long double sum = 0;
      for (std::size_t s = 0; s < count; ++s) {
        for (std::size_t to = 0; to < count; ++to) before[s] += moves[s * count + to] * likelihood(b, to) * backward[to];
        sum += before[s] * forward[b - 1][s];
      }
      for (std::size_t s = 0; s < count; ++s) {
        backward[s] = before[s] / sum;
        smoothed[b - 1][s] = forward[b - 1][s] * backward[s];
      }
    }
  }
};

TEST(StatePaths, HaveTheEvidenceOfADenseForwardPass) {
  const RunStates states(1000us);
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto of_level = drawn_evidence(60, motion_levels.size(), seed), of_pattern = drawn_evidence(60, happenings, seed + 10);
    const BinLikelihoods likelihoods(of_level, of_pattern);
    const auto arm = moving_arm(60);
    const Dense dense(states, likelihoods, arm, 0.05, 0.2);
    EXPECT_NEAR(filtered(states, likelihoods, arm, false).log_evidence, static_cast<double>(dense.log_evidence), 1e-4) << seed;
  }
}

TEST(StatePaths, HaveTheEvidenceOfSingleSequencesWhereSeveralShareTheirEnds) {
  const RunStates states(1000us);
  const auto of_level = drawn_evidence(60, motion_levels.size(), 7);
  const BinLikelihoods likelihoods(of_level, {});
  std::vector<std::vector<std::uint8_t>> arms{moving_arm(60), moving_arm(60), std::vector<std::uint8_t>(60, arm_still)};
  arms[1][25] = arm_starts;
  for (const std::size_t end : {std::size_t{60}, std::size_t{50}, std::size_t{1}}) {
    std::vector<std::vector<std::uint8_t>> alike = arms;  // from `end` on
    for (auto& arm : alike) std::fill(arm.begin() + static_cast<std::ptrdiff_t>(end), arm.end(), arm_still);
    alike.push_back(alike.front());
    const std::vector<double> evidences = log_evidences(states, likelihoods, alike);
    ASSERT_EQ(evidences.size(), alike.size());
    for (std::size_t i = 0; i < alike.size(); ++i)
      EXPECT_NEAR(evidences[i], filtered(states, likelihoods, alike[i], false).log_evidence, 1e-6) << end << ", " << i;
  }
  EXPECT_TRUE(log_evidences(states, likelihoods, {}).empty());
}

TEST(StatePaths, AreDrawnFromTheSmoothedProbabilities) {
  constexpr int draws = 4000;
  const RunStates states(1000us);
  const auto of_level = drawn_evidence(40, motion_levels.size(), 5);
  const BinLikelihoods likelihoods(of_level, {});
  const auto arm = moving_arm(40);
  const Dense dense(states, likelihoods, arm, 0.05, 0.2);
  const Filtered kept = filtered(states, likelihoods, arm, true);
  Random random(1);
  std::vector<std::vector<double>> share(40, std::vector<double>(happenings, 0.0));
  for (const Path& path : drawn_paths(states, kept, arm, draws, random)) {
    for (std::size_t b = 0; b < path.size(); ++b) share[b][static_cast<std::size_t>(states.happening_of(path[b]))] += 1.0 / draws;
  }
  for (std::size_t b = 0; b < 40; ++b) {
    std::vector<double> expected(happenings, 0.0);
    for (std::size_t s = 0; s < states.count(); ++s)
      expected[static_cast<std::size_t>(states.happening_of(s))] += static_cast<double>(dense.smoothed[b][s]);
    for (std::size_t h = 0; h < happenings; ++h)
      EXPECT_NEAR(share[b][h], expected[h], 5 * std::sqrt(0.25 / draws)) << "bin " << b << ", happening " << h;
  }
}

TEST(StatePaths, StayFiniteWhereEvidenceIsHuge) {
  const RunStates states(1000us);
  std::vector<double> of_level(30 * motion_levels.size(), 0.0);
  for (std::size_t b = 0; b < 20; ++b) {
    for (std::size_t level = 1; level < motion_levels.size(); ++level)
      of_level[b * motion_levels.size() + level] = level == 8 ? 1e9 : -200;
  }
  const BinLikelihoods likelihoods(of_level, {});
  const std::vector<std::uint8_t> arm(30, arm_unknown);
  const Filtered kept = filtered(states, likelihoods, arm, true);
  EXPECT_TRUE(std::isfinite(kept.log_evidence));
  Random random(1);
  const Path path = drawn_paths(states, kept, arm, 1, random).front();
  EXPECT_EQ(states.level_of(path[15], arm_unknown), 8U);
}

}  // namespace
}  // namespace tactile::labels
