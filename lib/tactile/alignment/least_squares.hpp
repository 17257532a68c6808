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

/// Descends from `parameters` to a minimum, which `parameters` gets: at most this many iterations, fewer if one gains less than a
/// millionth. Derivatives are differences, forward or, where these are impossible, backward. The method is Eigen's, of Levenberg
/// and Marquardt; a step to impossible parameters is shortened. Nothing moves if there are more
/// parameters than residuals.
/// @return the sum of squares reached; infinite if the first parameters are impossible
/// Source: J. J. More, The Levenberg-Marquardt algorithm: implementation and theory, Lecture Notes in Mathematics 630 (1978).
double descend(const LeastSquares& problem, std::vector<double>& parameters, int iterations);

/// J^T J of the residuals' derivatives J, row by row; parameters that are held have 0. The parameters must be possible.
std::vector<double> curvature_at(const LeastSquares& problem, const std::vector<double>& parameters);

}  // namespace tactile::alignment
