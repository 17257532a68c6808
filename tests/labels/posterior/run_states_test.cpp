#include "tactile/labels/posterior/run_states.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "labels/posterior/dense_transitions.hpp"
#include "tactile/labels/posterior/run_model_numbers.hpp"

namespace tactile::labels {
namespace {

TEST(RunStates, GoSomewhereFromEachStateForEachConditionOfTheArm) {
  const RunStates states(1000us);
  for (std::uint8_t arm = 0; arm < arm_conditions; ++arm) {
    const auto all = test::dense_transitions(states, arm);
    for (std::size_t from = 0; from < states.count(); ++from) {
      const double sum = std::accumulate(all[from].begin(), all[from].end(), 0.0);
      EXPECT_NEAR(sum, 1, 1e-12) << "from " << from << ", arm " << int{arm};
    }
  }
}

TEST(RunStates, AreTheSameForwardsAndBackwards) {
  const RunStates states(2000us);
  for (std::uint8_t arm = 0; arm < arm_conditions; ++arm) {
    const auto all = test::dense_transitions(states, arm);
    for (std::size_t to = 0; to < states.count(); ++to) {
      std::vector<double> backwards(states.count(), 0.0);
      for (const StateTransitions::Step& step : states.transitions(arm).backwards.of(to)) backwards[step.to] = step.probability;
      for (std::size_t from = 0; from < states.count(); ++from)
        EXPECT_NEAR(backwards[from], all[from][to], 1e-15) << from << ", " << to;
    }
  }
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
  const auto all = test::dense_transitions(states, arm);
  for (std::size_t s = 0; s < states.count(); ++s) {
    if (states.happening_of(s) != Happening::held || states.level_of(s, arm) != 0) continue;
    for (std::size_t to = 0; to < states.count(); ++to) sum += states.happening_of(to) == Happening::slip ? all[s][to] : 0;
  }
  return sum;
}

TEST(RunStates, SlipSoonerTheFasterTheArm) {
  const RunStates states(1000us);
  EXPECT_LT(slips_from_held(states, arm_still), 1e-4);
  for (std::size_t faster = 2; faster <= arm_speeds.size(); ++faster) {
    const auto speed = static_cast<std::uint8_t>(faster);
    EXPECT_GT(slips_from_held(states, speed), slips_from_held(states, speed - 1));
  }
  EXPECT_NEAR(slips_from_held(states, 5), numbers::slips * (1 - std::exp(-25 / numbers::slack_mm / 1000)), 0.002)
      << "25 mm/s for 1 ms";
}

TEST(RunStates, SlipAtOnceWithoutSlackWhateverTheBin) {
  for (const microseconds bin : {1000us, 8000us}) {
    const double slips = slips_from_held(RunStates(bin), arm_starts);
    EXPECT_NEAR(slips, numbers::slips * numbers::without_slack, 0.05) << bin.count();
  }
}

TEST(RunStates, SlipWhereAFilmShowsMotion) {
  const RunStates states(1000us);
  EXPECT_GT(slips_from_held(states, film_moves), 50 * slips_from_held(states, film_still));
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
