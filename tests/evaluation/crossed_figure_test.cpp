#include "tactile/evaluation/crossed_figure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/core/random.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::evaluation {
namespace {

/// The mean over objects of the mean of each one's values.
Statistic mean_of_objects(std::vector<double> values) {
  return mean_over_objects([values = std::move(values)](std::span<const std::size_t> of) -> std::optional<double> {
    double sum = 0;
    for (const std::size_t index : of) sum += values[index];
    return sum / static_cast<double>(of.size());
  });
}

Statistic median_of_all(std::vector<double> values) {
  return [values = std::move(values)](const RunsByObject& objects) -> std::optional<double> {
    std::vector<double> all;
    for (const auto& object : objects) {
      for (const std::size_t index : object) all.push_back(values[index]);
    }
    return median(all);
  };
}

/// Cells of one object, numbered by training, then run.
CrossedObject all_cells(std::size_t trainings, std::size_t runs, std::size_t first_index = 0) {
  CrossedObject cells;
  for (std::size_t training = 0; training < trainings; ++training) {
    for (std::size_t run = 0; run < runs; ++run) cells.push_back({training, run, first_index++});
  }
  return cells;
}

CrossedResults all_cells_of(std::size_t objects, std::size_t trainings, std::size_t runs) {
  CrossedResults results;
  for (std::size_t object = 0; object < objects; ++object)
    results.push_back(all_cells(trainings, runs, object * trainings * runs));
  return results;
}

// Accuracies of four objects, by training, then run; crossed_figure_reference.py has the same.
const std::vector<double> accuracies{0.91, 0.94, 0.93, 0.97, 0.90, 0.92, 0.82, 0.85, 0.88, 0.86, 0.79, 0.80,
                                     0.97, 0.99, 0.98, 0.96, 0.95, 0.99, 0.73, 0.78, 0.80, 0.84, 0.70, 0.75};

/// The first two objects of these as one with four runs, by training.
const std::vector<double> of_four_runs{0.91, 0.94, 0.82, 0.85, 0.93, 0.97, 0.88, 0.86, 0.90, 0.92, 0.79, 0.80};

/// Of Student's t with two degrees of freedom, at 95 %: the quantile that leaves out half of 5 %. From SciPy.
constexpr double t_of_2 = 6.2053468166;

TEST(StudentQuantile, IsThatOfSciPy) {
  EXPECT_NEAR(student_quantile(1, 0.95), 12.7062047362, 1e-9);
  EXPECT_NEAR(student_quantile(2, 0.95), 4.3026527297, 1e-9);
  EXPECT_NEAR(student_quantile(3, 0.99), 5.8409093097, 1e-9);
  EXPECT_NEAR(student_quantile(9, 0.95), 2.2621571628, 1e-9);
  EXPECT_NEAR(student_quantile(30, 0.995), 3.0297982236, 1e-9);
}

TEST(CrossedFigureOfObject, OfOneTrainingIsStudentsInterval) {
  // Runs of 1, 3 and 5: mean 3, standard error 2 / sqrt(3), two degrees of freedom.
  const results::Figure figure = figure_of_object(all_cells(1, 3), mean_of_objects({1, 3, 5}));
  EXPECT_EQ(figure.n, 3U);
  EXPECT_DOUBLE_EQ(figure.value, 3);
  EXPECT_NEAR(*figure.low, 3 - t_of_2 * 2 / std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(*figure.high, 3 + t_of_2 * 2 / std::sqrt(3.0), 1e-9);
}

TEST(CrossedFigureOfObject, HasNoBoundsBelowThreeRuns) {
  const results::Figure figure = figure_of_object(all_cells(5, 2), mean_of_objects({1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
  EXPECT_DOUBLE_EQ(figure.value, 5.5);
  EXPECT_EQ(figure.n, 2U);
  EXPECT_FALSE(figure.low || figure.high);
  EXPECT_EQ(figure_of_object({}, mean_of_objects({})).n, 0U);
}

TEST(CrossedFigureOfObject, HasTheEffectOfTrainings) {
  // Three runs that do not differ, and trainings of 1, 2 and 3: the standard error of the mean is 1 / sqrt(3).
  const results::Figure figure = figure_of_object(all_cells(3, 3), mean_of_objects({1, 1, 1, 2, 2, 2, 3, 3, 3}));
  EXPECT_NEAR(*figure.high, 2 + t_of_2 / std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(*figure.low, 2 - t_of_2 / std::sqrt(3.0), 1e-9);
}

TEST(CrossedFigureOfObject, CountsNoiseThatTrainingsAndRunsShareOnce) {
  // A Latin square: each training and each run has the mean 2, so neither changes the figure, and nothing is left to be spread.
  const auto square = mean_of_objects({1, 2, 3, 2, 3, 1, 3, 1, 2});
  EXPECT_FALSE(figure_of_object(all_cells(3, 3), square).has_interval());
  // One cell of another value: the runs' mean squares, the trainings' and those of both are the same, so that the runs' remain.
  const results::Figure figure = figure_of_object(all_cells(3, 3), mean_of_objects({0, 0, 0, 0, 9, 0, 0, 0, 0}));
  EXPECT_NEAR(*figure.high, 1 + t_of_2, 1e-9);  // the runs' means are 0, 3, 0: standard error 1
}

TEST(CrossedFigureOfObject, HasNoBoundsWithTwoTrainings) {
  const results::Figure figure = figure_of_object(all_cells(2, 3), mean_of_objects({0, 3, 0, 3, 0, 6}), {}, {0, 10, 1});
  EXPECT_DOUBLE_EQ(figure.value, 2);
  EXPECT_EQ(figure.trainings, 2U);
  EXPECT_FALSE(figure.low || figure.high);
}

TEST(CrossedFigureOfObject, IsThatOfTheAnalysisOfVariance) {  // crossed_figure_reference.py
  const results::Figure figure = figure_of_object(all_cells(3, 4), mean_of_objects(of_four_runs));
  EXPECT_NEAR(*figure.low, 0.7269453379199219, 1e-9);
  EXPECT_NEAR(*figure.high, 1.034721328746745, 1e-9);
}

TEST(CrossedFigureOfObject, MayHaveMissingCells) {  // crossed_figure_reference.py
  CrossedObject cells = all_cells(3, 4);
  std::erase_if(cells, [](const CrossedCell& cell) { return cell.training == cell.run; });
  const results::Figure figure = figure_of_object(cells, mean_of_objects(of_four_runs), {}, {0, 1});
  EXPECT_EQ(figure.n, 4U);
  EXPECT_NEAR(*figure.low, 0.7317851335265946, 1e-9);
  EXPECT_NEAR(*figure.high, 0.9609143330479943, 1e-9);
}

TEST(CrossedFigureOfObject, OfOneRunPerTrainingIsThatOfItsCells) {
  // Each training is judged on one run of its own: three results, and Student's interval of their mean.
  const CrossedObject cells{{0, 2, 0}, {1, 0, 1}, {2, 1, 2}};
  const results::Figure figure = figure_of_object(cells, mean_of_objects({1, 3, 5}));
  EXPECT_NEAR(*figure.high, 3 + t_of_2 * 2 / std::sqrt(3.0), 1e-9);
}

TEST(CrossedFigureOfTheseObjects, LeavesOutHowObjectsDiffer) {
  // Runs of 1, 3, 5 and of 101, 103, 105: each object's mean has the variance 4 / 3, and theirs a half of that; 2 + 2 degrees.
  const CrossedResults objects{all_cells(1, 3), all_cells(1, 3, 3)};
  const results::Figure figure = figure_of_these_objects(objects, mean_of_objects({1, 3, 5, 101, 103, 105}));
  const double half = student_quantile(4, 0.975) * std::sqrt(2.0 / 3);
  EXPECT_DOUBLE_EQ(figure.value, 53);
  EXPECT_NEAR(*figure.low, 53 - half, 1e-9);
  EXPECT_NEAR(*figure.high, 53 + half, 1e-9);
  // Where the runs of one object alone differ, the other adds no degrees.
  const results::Figure of_one = figure_of_these_objects(objects, mean_of_objects({1, 3, 5, 9, 9, 9}));
  EXPECT_NEAR(*of_one.high, 6 + t_of_2 / std::sqrt(3.0), 1e-9);
}

TEST(CrossedFigureOfTheseObjects, IsThatOfTheAnalysisOfVariance) {  // crossed_figure_reference.py
  std::vector<double> values = of_four_runs;
  values.insert(values.end(), {0.97, 0.99, 0.73, 0.78, 0.98, 0.96, 0.80, 0.84, 0.95, 0.99, 0.70, 0.75});
  const results::Figure figure = figure_of_these_objects({all_cells(3, 4), all_cells(3, 4, 12)}, mean_of_objects(values));
  EXPECT_NEAR(*figure.low, 0.7288729601840125, 1e-9);
  EXPECT_NEAR(*figure.high, 1.021960373149321, 1e-9);
}

TEST(CrossedFigureOfTheseObjects, HasNoBoundsWhereOneHasLessThanThreeRuns) {
  const results::Figure figure = figure_of_these_objects({all_cells(1, 3), all_cells(1, 2, 3)}, mean_of_objects({1, 3, 5, 7, 9}));
  EXPECT_DOUBLE_EQ(figure.value, 5.5);
  EXPECT_FALSE(figure.low || figure.high);
}

TEST(CrossedFigureOverObjects, IsThatOfTheAnalysisOfVariance) {  // crossed_figure_reference.py
  const results::Figure figure = figure_over_objects(all_cells_of(4, 3, 2), mean_of_objects(accuracies));
  EXPECT_EQ(figure.n, 4U);
  EXPECT_NEAR(*figure.low, 0.663049467457264, 1e-9);
  EXPECT_NEAR(*figure.high, 1.0877838658760695, 1e-9);
}

TEST(CrossedFigureOverObjects, HasTheStandardErrorOfAMixedModel) {
  // Two intervals of different confidence give both variances; their sum is the square of statsmodels' standard error (REML).
  const auto half = [](double confidence) {
    const results::Figure figure =
        figure_over_objects(all_cells_of(4, 3, 2), mean_of_objects(accuracies), {.confidence = confidence});
    return *figure.high - figure.value;
  };
  const auto square_of_t = [](std::size_t freedom, double confidence) {
    return std::pow(student_quantile(freedom, 1 - 0.5 * (1 - confidence)), 2);
  };
  const double a = square_of_t(3, 0.95), b = square_of_t(2, 0.95), c = square_of_t(3, 0.5), d = square_of_t(2, 0.5);
  const double wide = half(0.95) * half(0.95), narrow = half(0.5) * half(0.5);
  const double of_objects = (wide * d - narrow * b) / (a * d - b * c), of_trainings = (a * narrow - c * wide) / (a * d - b * c);
  EXPECT_NEAR(std::sqrt(of_objects + of_trainings), 0.048535, 2e-6);
}

TEST(CrossedFigureOverObjects, StaysWithinTheRangeAndContainsItsValue) {
  const std::vector<double> values{1, 1, 1, 1, 1, 0.9, 1, 1, 0.97};
  const results::Figure plain = figure_over_objects(all_cells_of(9, 1, 1), mean_of_objects(values));
  EXPECT_GT(*plain.high, 1);
  const results::Figure within = figure_over_objects(all_cells_of(9, 1, 1), mean_of_objects(values), {}, {0, 1});
  EXPECT_LT(*within.high, 1);
  EXPECT_GT(*within.high, within.value);
  EXPECT_LT(*within.low, *plain.low);  // the side on which accuracies near 1 spread further
  EXPECT_GT(*within.low, 0);
}

TEST(CrossedFigureOverObjects, OfAValueAtALimitReachesOnlyInwards) {
  const results::Figure figure =
      figure_over_objects(all_cells_of(8, 1, 1), median_of_all({1, 1, 1, 1, 1, 0.5, 0.5, 0.4}), {}, {0, 1});
  EXPECT_DOUBLE_EQ(figure.value, 1);
  EXPECT_DOUBLE_EQ(*figure.high, 1);
  EXPECT_LT(*figure.low, 0.9);
  EXPECT_GE(*figure.low, 0);
}

TEST(CrossedFigureOverObjects, TurnsWithItsQuantity) {
  // Errors are 1 - accuracies, in the same range: their bounds are 1 - those of the accuracies.
  std::vector<double> errors = accuracies;
  for (double& error : errors) error = 1 - error;
  const auto cells = all_cells_of(4, 3, 2);
  const results::Figure right = figure_over_objects(cells, mean_of_objects(accuracies), {}, {0, 1});
  const results::Figure wrong = figure_over_objects(cells, mean_of_objects(errors), {}, {0, 1});
  EXPECT_NEAR(*wrong.low, 1 - *right.high, 1e-9);
  EXPECT_NEAR(*wrong.high, 1 - *right.low, 1e-9);
}

TEST(CrossedFigureOverObjects, OfDelaysWithoutALimitIsThatOfACount) {  // from SciPy
  const std::vector<double> delays{2, 2, 4, 2, 12};
  const double inf = std::numeric_limits<double>::infinity();
  const results::Figure figure = figure_over_objects(all_cells_of(5, 1, 1), mean_of_objects(delays), {}, {0, inf});
  EXPECT_NEAR(*figure.low, 0.3680484377363607, 1e-6);
  EXPECT_NEAR(*figure.high, 17.952046000576356, 1e-6);
}

TEST(CrossedFigureOverObjects, OfDelaysStaysBelowTheirLimit) {
  const results::Figure figure =
      figure_over_objects(all_cells_of(5, 1, 1), mean_of_objects({490, 500, 500, 100, 500}), {}, {0, 500, 2});
  EXPECT_GT(*figure.high, figure.value);
  EXPECT_LE(*figure.high, 500);
}

/// Ten objects with four runs of 13 touches each; of each object a number of touches that are missed, all in its first run.
results::Figure missed_of_520(const std::vector<double>& missed) {
  std::vector<double> shares(40, 0.0);
  for (std::size_t object = 0; object < missed.size(); ++object) shares[4 * object] = missed[object] / 13;
  return figure_over_objects(all_cells_of(10, 1, 4), mean_of_objects(shares), {}, {0, 1, 1.0 / 13});
}

TEST(CrossedFigureOverObjects, OfFewEventsIsThatOfAsManyTrials) {  // crossed_figure_reference.py
  const results::Figure none = missed_of_520({}), one = missed_of_520({1}), six = missed_of_520({6}),
                        apart = missed_of_520({1, 1, 1, 1, 1, 1});
  EXPECT_DOUBLE_EQ(*none.low, 0);
  EXPECT_NEAR(*none.high, 1 - std::pow(0.025, 1 / 520.0), 1e-9) << "the exact one of 0 of 520";
  EXPECT_NEAR(*one.low, 2.807975186105043e-06, 1e-10);
  EXPECT_NEAR(*one.high, 0.016986598693895242, 1e-9);
  EXPECT_NEAR(*six.low, 1.5788078165530037e-05, 1e-10);
  EXPECT_NEAR(*six.high, 0.09886058396385305, 1e-9) << "six in one object are one event of which no other object tells";
  EXPECT_NEAR(*apart.low, 0.004691942610184505, 1e-9);
  EXPECT_NEAR(*apart.high, 0.02350333511902518, 1e-9);
}

TEST(CrossedFigureOverObjects, StaysAtTheMiddleWhereNothingVaries) {
  // A difference of 0 in each of ten runs of 100 samples leaves room for 3.69 samples of 1000.
  const results::Figure same =
      figure_over_objects(all_cells_of(10, 1, 1), mean_of_objects(std::vector<double>(10, 0.0)), {}, {-1, 1, 0.01});
  EXPECT_NEAR(*same.high, 0.00369, 1e-4);
  EXPECT_NEAR(*same.low, -*same.high, 1e-9);
}

TEST(CrossedFigureOverObjects, HasNoBoundsWhereAllGiveTheSameUnlessTheStepIsKnown) {
  // Ten objects with a hundred samples each and no error: the exact interval of 1000 of 1000.
  const Statistic perfect = mean_of_objects(std::vector<double>(10, 1.0));
  const results::Figure unknown = figure_over_objects(all_cells_of(10, 1, 1), perfect, {}, {0, 1});
  EXPECT_DOUBLE_EQ(unknown.value, 1);
  EXPECT_FALSE(unknown.low || unknown.high);
  const results::Figure known = figure_over_objects(all_cells_of(10, 1, 1), perfect, {}, {0, 1, 0.01});
  EXPECT_NEAR(*known.low, std::pow(0.025, 1 / 1000.0), 1e-9);
  EXPECT_DOUBLE_EQ(*known.high, 1);
}

TEST(CrossedFigureOverObjects, DependsOnTheSeedOnlyWhereDrawsCount) {
  const auto cells = all_cells_of(4, 3, 2);
  const auto low = [&](const Statistic& statistic, std::uint64_t seed) {
    return figure_over_objects(cells, statistic, {.draws = 200, .seed = seed}).low;
  };
  EXPECT_EQ(low(mean_of_objects(accuracies), 1), low(mean_of_objects(accuracies), 2));
  const Statistic rough = median_of_all({2, 2, 2, 2, 2, 2, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 6, 6, 6, 6, 6, 6});
  EXPECT_EQ(low(rough, 1), low(rough, 1));
  EXPECT_NE(low(rough, 1), low(rough, 2));
}

TEST(CrossedFigureOverObjects, OfAMedianComesFromDrawsWhereLeavingOutGivesNothing) {
  // Five of nine objects have 4 ms. Without any one the median is still 4: only draws show that it may be 2 or 6.
  const std::vector<double> delays{2, 2, 4, 4, 4, 4, 4, 6, 6};
  const results::Figure figure = figure_over_objects(all_cells_of(9, 1, 1), median_of_all(delays));
  EXPECT_DOUBLE_EQ(figure.value, 4);
  EXPECT_LT(*figure.low, 3.5);
  EXPECT_GT(*figure.high, 4.5);
}

TEST(CrossedFigureOverObjects, OfADifferenceIsPaired) {
  // Objects differ by 0.3, two settings by 0.01 in each cell, up to 0.002: the difference is known far better than either
  // accuracy.
  const auto difference = [](const RunsByObject& objects) -> std::optional<double> {
    std::vector<double> others = accuracies;
    for (std::size_t i = 0; i < others.size(); ++i) others[i] += 0.01 + 0.001 * static_cast<double>(i % 3);
    return *mean_of_objects(others)(objects) - *mean_of_objects(accuracies)(objects);
  };
  const results::Figure figure = figure_over_objects(all_cells_of(4, 3, 2), difference, {}, {-1, 1});
  EXPECT_NEAR(figure.value, 0.011, 1e-12);
  EXPECT_GT(*figure.low, 0.005);
  EXPECT_LT(*figure.high, 0.017);
}

TEST(CrossedFigureOverObjects, PassesOverObjectsWithoutCells) {
  CrossedResults cells = all_cells_of(3, 1, 4);
  const auto statistic = mean_of_objects({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  const results::Figure without = figure_over_objects(cells, statistic);
  cells.insert(cells.begin() + 1, CrossedObject{});
  const results::Figure with = figure_over_objects(cells, statistic);
  EXPECT_EQ(with.n, 3U);
  ASSERT_TRUE(with.low);
  EXPECT_EQ(with.low, without.low);
  EXPECT_EQ(figure_over_objects({{}, {}}, statistic).n, 0U);
}

TEST(CrossedFigureOverObjects, NeverSeesAnEmptyList) {
  // Each object has results of one training only.
  const CrossedResults cells{{{0, 0, 0}}, {{1, 0, 1}}, {{2, 0, 2}}};
  std::size_t calls = 0;
  const Statistic counting = [&](const RunsByObject& objects) -> std::optional<double> {
    ++calls;
    EXPECT_TRUE(std::none_of(objects.begin(), objects.end(), [](const auto& object) { return object.empty(); }));
    return static_cast<double>(objects.size());
  };
  figure_over_objects(cells, counting);
  EXPECT_GT(calls, 1000U);
}

TEST(CrossedFigureOverObjects, HasNoBoundsWhereMostDrawsGiveNothing) {
  const Statistic rare = [](const RunsByObject& objects) -> std::optional<double> {
    if (std::count(objects.begin(), objects.end(), std::vector<std::size_t>{0}) != 1) return std::nullopt;
    return static_cast<double>(objects.size() + objects.back().front());
  };
  // Of eight draws from eight, one object is there exactly once in 39 % of cases.
  const results::Figure figure = figure_over_objects(all_cells_of(8, 1, 1), rare);
  EXPECT_DOUBLE_EQ(figure.value, 15);
  EXPECT_FALSE(figure.has_interval());
}

TEST(CrossedFigureOverObjects, CoversTheExpectedValueOverNewTrainingsAndObjects) {
  // Effects of trainings and of objects of the same size, three trainings, five objects with two runs.
  Random random(11);
  int covered = 0;
  constexpr int experiments = 400;
  for (int i = 0; i < experiments; ++i) {
    std::vector<double> values, of_training(3);
    for (double& effect : of_training) effect = random.normal();
    for (int object = 0; object < 5; ++object) {
      const double of_object = random.normal();
      for (const double effect : of_training) {
        const double both = of_object + effect + 0.5 * random.normal();
        for (int run = 0; run < 2; ++run) values.push_back(both + 0.5 * random.normal());
      }
    }
    const results::Figure figure = figure_over_objects(all_cells_of(5, 3, 2), mean_of_objects(values), {.draws = 20});
    covered += *figure.low <= 0 && 0 <= *figure.high ? 1 : 0;
  }
  EXPECT_GT(covered, experiments * 0.93);
  EXPECT_LT(covered, experiments * 0.995);
}

}  // namespace
}  // namespace tactile::evaluation
