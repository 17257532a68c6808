#pragma once

#include <functional>
#include <span>
#include <vector>

namespace tactile {

/// What is to be fitted: the parameters whose residuals have the least sum of squares.
struct LeastSquares {
  /// Sets the residuals at these parameters; as many at each call. @return false where the parameters cannot be
  std::function<bool(std::span<const double> parameters, std::vector<double>& residuals)> residuals;
  std::vector<double> steps;  ///< of each parameter, for the derivatives; 0: the parameter is held
};

/// Follows the squares down from `parameters`, and leaves there where it ends: at most so many iterations, fewer when one gains
/// less than a millionth. Derivatives are differences, forward or, where that cannot be, back.
/// @return the sum of squares reached; infinite if the parameters to start from cannot be
/// Source: D. W. Marquardt, An algorithm for least-squares estimation of nonlinear parameters, SIAM J. Appl. Math. 11 (1963).
double descend(const LeastSquares& problem, std::vector<double>& parameters, int iterations);

/// J^T J of the residuals' derivatives J, row by row; parameters that are held have 0. The parameters must be possible.
std::vector<double> curvature_at(const LeastSquares& problem, const std::vector<double>& parameters);

}  // namespace tactile
