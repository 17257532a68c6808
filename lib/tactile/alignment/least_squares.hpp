#pragma once

#include <functional>
#include <span>
#include <vector>

namespace tactile::alignment {

/// A problem: the parameters whose residuals have the least sum of squares.
struct LeastSquares {
  /// Sets the residuals at these parameters; the same number at each call. @return false where the parameters are impossible
  std::function<bool(std::span<const double> parameters, std::vector<double>& residuals)> residuals;
  std::vector<double> steps;  ///< of each parameter, for the derivatives; 0: the parameter is held
};

/// Descends from `parameters` to a minimum, which `parameters` gets: at most so many iterations, fewer if one gains less than a
/// millionth. Derivatives are differences, forward or, where these are impossible, backward.
/// @return the sum of squares reached; infinite if the first parameters are impossible
/// Source: D. W. Marquardt, An algorithm for least-squares estimation of nonlinear parameters, SIAM J. Appl. Math. 11 (1963).
double descend(const LeastSquares& problem, std::vector<double>& parameters, int iterations);

/// J^T J of the residuals' derivatives J, row by row; parameters that are held have 0. The parameters must be possible.
std::vector<double> curvature_at(const LeastSquares& problem, const std::vector<double>& parameters);

}  // namespace tactile::alignment
