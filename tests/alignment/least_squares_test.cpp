#include "tactile/alignment/least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tactile::alignment {
namespace {

/// y = a e^(-b x) at x = 0, 0.1 ... 2, where a = 3 and b = 2; only a positive b can be.
LeastSquares decay() {
  return {.residuals =
              [](std::span<const double> p, std::vector<double>& residuals) {
                residuals.clear();
                for (int i = 0; i <= 20; ++i) residuals.push_back(p[0] * std::exp(-p[1] * 0.1 * i) - 3 * std::exp(-2 * 0.1 * i));
                return p[1] > 0;
              },
          .steps = {1e-6, 1e-6}};
}

TEST(Descend, FindsTheParametersOfADecay) {
  std::vector<double> parameters{1, 0.1};
  EXPECT_NEAR(descend(decay(), parameters, 100), 0, 1e-12);
  EXPECT_NEAR(parameters[0], 3, 1e-6);
  EXPECT_NEAR(parameters[1], 2, 1e-6);
}

TEST(Descend, LeavesAHeldParameterWhereItIs) {
  LeastSquares problem = decay();
  problem.steps[0] = 0;
  std::vector<double> parameters{3, 1};
  descend(problem, parameters, 100);
  EXPECT_EQ(parameters[0], 3);
  EXPECT_NEAR(parameters[1], 2, 1e-6);
}

TEST(Descend, StaysWhereParametersArePossible) {
  LeastSquares problem = decay();
  problem.residuals = [of_decay = problem.residuals](std::span<const double> p, std::vector<double>& residuals) {
    return of_decay(p, residuals) && p[1] <= 1.5;
  };
  std::vector<double> parameters{1, 1.5};  // its derivative is to be had on one side only
  const double left = descend(problem, parameters, 100);
  EXPECT_LE(parameters[1], 1.5);
  EXPECT_GT(parameters[0], 2);
  EXPECT_LT(left, 1);
}

TEST(Descend, GivesInfinityWhereItCannotStart) {
  std::vector<double> parameters{1, -1};
  EXPECT_EQ(descend(decay(), parameters, 100), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parameters, (std::vector<double>{1, -1}));
}

TEST(Descend, StaysIfThereAreMoreParametersThanValues) {
  const LeastSquares sum{.residuals =
                             [](std::span<const double> p, std::vector<double>& residuals) {
                               residuals = {p[0] + p[1] - 3};
                               return true;
                             },
                         .steps = {0.5, 0.5}};
  std::vector<double> parameters{1, 0};
  EXPECT_EQ(descend(sum, parameters, 10), 4);
  EXPECT_EQ(parameters, (std::vector<double>{1, 0}));
}

TEST(CurvatureAt, IsTheProductOfTheDerivatives) {
  const LeastSquares line{.residuals =
                              [](std::span<const double> p, std::vector<double>& residuals) {
                                residuals = {p[0] + 1 * p[1], p[0] + 2 * p[1], p[0] + 3 * p[1]};
                                return true;
                              },
                          .steps = {0.5, 0.5}};
  EXPECT_EQ(curvature_at(line, {0, 0}), (std::vector<double>{3, 6, 6, 14}));
}

}  // namespace
}  // namespace tactile::alignment
