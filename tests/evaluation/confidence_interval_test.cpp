#include "tactile/evaluation/confidence_interval.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tactile/core/random.hpp"

namespace tactile::evaluation {
namespace {

/// The mean over all runs given of `values[run]`.
Statistic mean_of(std::vector<double> values) {
  return [values = std::move(values)](const RunsByObject& runs) -> std::optional<double> {
    double sum = 0, n = 0;
    for (const auto& object : runs) {
      for (const std::size_t run : object) {
        sum += values[run];
        n += 1;
      }
    }
    if (n == 0) return std::nullopt;
    return sum / n;
  };
}

/// The first results, each of another run.
CrossedObject first(std::size_t count) {
  CrossedObject cells;
  for (std::size_t i = 0; i < count; ++i) cells.push_back({.training = 0, .run = i, .index = i});
  return cells;
}

/// The results of one training, each of another run.
CrossedResults of_one_training(const RunsByObject& objects) {
  CrossedResults results;
  for (const auto& object : objects) {
    CrossedObject& cells = results.emplace_back();
    for (const std::size_t index : object) cells.push_back({.training = 0, .run = cells.size(), .index = index});
  }
  return results;
}

TEST(FigureOfObject, HasNoBoundsBelowThreeRuns) {
  const results::Figure two = figure_of_object(first(2), mean_of({1, 3}));
  EXPECT_DOUBLE_EQ(two.value, 2);
  EXPECT_EQ(two.n, 2U);
  EXPECT_FALSE(two.low || two.high);
  const results::Figure three = figure_of_object(first(3), mean_of({1, 3, 5}));
  EXPECT_TRUE(three.low && three.high);
}

TEST(FigureOfObject, MatchesTheBinomialOfOnesAndZeros) {
  // Of 10 runs half are 1: a draw's mean is binomial(10, 1/2) / 10, whose 2.5 % and 97.5 % quantiles are 0.2 and 0.8.
  const results::Figure figure = figure_of_object(first(10), mean_of({1, 1, 1, 1, 1, 0, 0, 0, 0, 0}));
  EXPECT_DOUBLE_EQ(figure.value, 0.5);
  EXPECT_DOUBLE_EQ(*figure.low, 0.2);
  EXPECT_DOUBLE_EQ(*figure.high, 0.8);
}

TEST(FigureOfObject, IsTheSameForTheSameSeedAndWiderForMoreConfidence) {
  const auto statistic = mean_of({3.14, 1.59, 2.65, 3.58, 9.79, 3.23, 8.46, 2.64});
  const results::Figure one = figure_of_object(first(8), statistic), again = figure_of_object(first(8), statistic);
  EXPECT_EQ(one.low, again.low);
  EXPECT_EQ(one.high, again.high);
  const results::Figure other_seed = figure_of_object(first(8), statistic, {.seed = 2});
  EXPECT_NE(one.low, other_seed.low);
  const results::Figure wider = figure_of_object(first(8), statistic, {.confidence = 0.99});
  EXPECT_LT(*wider.low, *one.low);
  EXPECT_GT(*wider.high, *one.high);
}

TEST(FigureOfObject, CoversTheTruthAboutAsOftenAsItSays) {
  Random random(7);
  int covered = 0;
  constexpr int experiments = 300;
  for (int i = 0; i < experiments; ++i) {
    std::vector<double> values(30);
    for (double& value : values) value = random.normal();
    const results::Figure figure = figure_of_object(first(30), mean_of(values), {.draws = 400});
    covered += *figure.low <= 0 && 0 <= *figure.high ? 1 : 0;
  }
  EXPECT_GT(covered, experiments * 0.88);
  EXPECT_LT(covered, experiments * 0.99);
}

TEST(FigureOverObjects, DrawsObjectsFirst) {
  // Three objects whose runs agree among themselves: only the drawing of objects spreads the figure, from -1 (all three the
  // first, one draw in 27) to 1, so both ends lie inside the middle 95 %.
  const CrossedResults runs = of_one_training({{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 9, 10, 11}});
  const results::Figure figure = figure_over_objects(runs, mean_of({-1, -1, -1, -1, 0, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_EQ(figure.n, 3U);
  EXPECT_DOUBLE_EQ(figure.value, 0);
  EXPECT_DOUBLE_EQ(*figure.low, -1);
  EXPECT_DOUBLE_EQ(*figure.high, 1);
}

TEST(FigureOverObjects, DrawsRunsWithinObjects) {
  // Three objects alike, each with runs 0 and 1: the spread comes from the runs alone.
  const CrossedResults runs = of_one_training({{0, 1}, {2, 3}, {4, 5}});
  const results::Figure figure = figure_over_objects(runs, mean_of({0, 1, 0, 1, 0, 1}));
  EXPECT_DOUBLE_EQ(figure.value, 0.5);
  EXPECT_LT(*figure.low, 0.2);
  EXPECT_GT(*figure.high, 0.8);
}

TEST(FigureOverObjects, PassesOverObjectsWithoutRuns) {
  const results::Figure figure = figure_over_objects(of_one_training({{0}, {}, {1}}), mean_of({1, 3}));
  EXPECT_EQ(figure.n, 2U);
  EXPECT_DOUBLE_EQ(figure.value, 2);
}

TEST(Figure, WithoutAnythingToMeasureIsNullInJson) {
  const results::Figure figure =
      figure_of_object(first(4), [](const RunsByObject&) -> std::optional<double> { return std::nullopt; });
  const nlohmann::json json = figure;
  EXPECT_EQ(json, nlohmann::json::parse(R"({"value": null, "low": null, "high": null, "n": 4, "trainings": 1})"));
}

TEST(Figure, HasNoBoundsWhereMostDrawsGiveNothing) {
  // Only run 0 has something to measure, and the statistic wants it to be more than half of what is drawn.
  const Statistic rare = [](const RunsByObject& runs) -> std::optional<double> {
    const auto zeros = std::count(runs[0].begin(), runs[0].end(), std::size_t{0});
    if (runs[0] != std::vector<std::size_t>{0, 1, 2, 3} && zeros < 3) return std::nullopt;
    return 1.0;
  };
  const results::Figure figure = figure_of_object(first(4), rare);
  EXPECT_DOUBLE_EQ(figure.value, 1);
  EXPECT_FALSE(figure.low || figure.high);
}

TEST(PoissonUpperBound, IsThatOfTheExactInterval) {
  // Half of the quantile of chi-squared at 0.975 with 2 (count + 1) degrees of freedom, as SciPy's gamma functions give it.
  EXPECT_NEAR(poisson_upper_bound(0), 3.688879454, 1e-8);
  EXPECT_NEAR(poisson_upper_bound(1), 5.571643391, 1e-8);
  EXPECT_NEAR(poisson_upper_bound(10), 18.390356042, 1e-8);
  EXPECT_NEAR(poisson_upper_bound(100), 121.626793792, 1e-7);
  EXPECT_NEAR(poisson_upper_bound(0, 0.9), 2.995732274, 1e-8) << "the rule of three";
  const double of_many = poisson_upper_bound(100'000);
  EXPECT_NEAR(of_many, 100'000 + 1.96 * 316.23, 5);
}

TEST(MeanOverObjects, LeavesOutObjectsThatGiveNothing) {
  const auto statistic = mean_over_objects([](std::span<const std::size_t> runs) -> std::optional<double> {
    if (runs.empty()) return std::nullopt;
    return static_cast<double>(runs.front());
  });
  EXPECT_DOUBLE_EQ(*statistic({{2}, {}, {4}}), 3);
  EXPECT_FALSE(statistic({{}, {}}).has_value());
}

}  // namespace
}  // namespace tactile::evaluation
