#include "tactile/labels/posterior/run_states.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace tactile::labels {
namespace {

TEST(RunStates, GoSomewhereFromEachStateForEachConditionOfTheArm) {
  const RunStates states(1000us);
  for (std::uint8_t arm = 0; arm < arm_conditions; ++arm) {
    const StateTransitions& moves = states.transitions(arm);
    for (std::size_t from = 0; from < states.count(); ++from) {
      const double sum = std::accumulate(moves.to_probability.begin() + moves.first_to[from],
                                         moves.to_probability.begin() + moves.first_to[from + 1], 0.0);
      EXPECT_NEAR(sum, 1, 1e-12) << "from " << from << ", arm " << int{arm};
    }
  }
}

TEST(RunStates, AreTheSameByOriginAndByTarget) {
  const RunStates states(2000us);
  const StateTransitions& moves = states.transitions(3);
  ASSERT_EQ(moves.to.size(), moves.from.size());
  std::vector<double> by_origin(states.count() * states.count(), 0.0), by_target = by_origin;
  for (std::size_t s = 0; s < states.count(); ++s) {
    for (std::uint32_t k = moves.first_to[s]; k < moves.first_to[s + 1]; ++k)
      by_origin[s * states.count() + moves.to[k]] = moves.to_probability[k];
    for (std::uint32_t k = moves.first_from[s]; k < moves.first_from[s + 1]; ++k)
      by_target[moves.from[k] * states.count() + s] = moves.from_probability[k];
  }
  EXPECT_EQ(by_origin, by_target);
}

TEST(RunStates, BeginUntouchedMostOften) {
  const RunStates states(1000us);
  std::array<double, happenings> begins{};
  for (std::size_t s = 0; s < states.count(); ++s)
    begins[static_cast<std::size_t>(states.happening_of(s))] += states.at_start()[s];
  EXPECT_NEAR(std::accumulate(begins.begin(), begins.end(), 0.0), 1, 1e-12);
  EXPECT_GT(begins[static_cast<std::size_t>(Happening::untouched)], 0.9);
}

/// How likely what is held begins to slip within a bin.
double slips_from_held(const RunStates& states, std::uint8_t arm) {
  double sum = 0;
  const StateTransitions& moves = states.transitions(arm);
  for (std::size_t s = 0; s < states.count(); ++s) {
    if (states.happening_of(s) != Happening::held || states.level_of(s, arm) != 0) continue;
    for (std::uint32_t k = moves.first_to[s]; k < moves.first_to[s + 1]; ++k) {
      if (states.happening_of(moves.to[k]) == Happening::slip) sum += moves.to_probability[k];
    }
  }
  return sum;
}

TEST(RunStates, SlipSoonerTheFasterTheArm) {
  const RunStates states(1000us);
  EXPECT_LT(slips_from_held(states, arm_still), 1e-4);
  for (std::uint8_t faster = 4; arm_moves(faster); ++faster)
    EXPECT_GT(slips_from_held(states, faster), slips_from_held(states, faster - 1));
  EXPECT_NEAR(slips_from_held(states, 5), 0.9 * (1 - std::exp(-25 / 0.12 / 1000)), 0.002)
      << "25 mm/s for 1 ms, of a slack of 0.12 mm";
}

TEST(RunStates, FollowTheArmsSpeedWhileTheSkinIsSheared) {
  const RunStates states(1000us);
  std::size_t following = 0;
  for (std::size_t s = 0; s < states.count(); ++s) {
    if (states.level_of(s, 1) == states.level_of(s, 7)) continue;
    ++following;
    EXPECT_TRUE(states.happening_of(s) == Happening::slip || states.happening_of(s) == Happening::firm_shear);
    for (std::uint8_t arm = 1; arm < 7; ++arm) EXPECT_LE(states.level_of(s, arm), states.level_of(s, arm + 1));
  }
  EXPECT_EQ(following, 2 * motion_levels.size());
}

}  // namespace
}  // namespace tactile::labels
