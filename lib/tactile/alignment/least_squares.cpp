#include "tactile/alignment/least_squares.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

namespace tactile::alignment {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Eigen::Map<const VectorXd> as_vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

MatrixXd jacobian_at(const LeastSquares& problem, const std::vector<double>& parameters, const std::vector<double>& residuals) {
  MatrixXd jacobian = MatrixXd::Zero(as_vector(residuals).size(), as_vector(parameters).size());
  std::vector<double> moved = parameters, there;
  for (std::size_t a = 0; a < parameters.size(); ++a) {
    if (problem.steps[a] == 0) continue;
    for (const double step : {problem.steps[a], -problem.steps[a]}) {
      moved[a] = parameters[a] + step;
      if (!problem.residuals(moved, there)) continue;
      jacobian.col(static_cast<Eigen::Index>(a)) = (as_vector(there) - as_vector(residuals)) / step;
      break;
    }
    moved[a] = parameters[a];
  }
  return jacobian;
}

}  // namespace

double descend(const LeastSquares& problem, std::vector<double>& parameters, int iterations) {
  constexpr double least_gain = 1e-6, most_damping = 1e8, least_damping = 1e-9, raise = 4, lower = 10;
  std::vector<double> residuals, tried, there(parameters.size());
  if (!problem.residuals(parameters, residuals)) return std::numeric_limits<double>::infinity();
  double cost = as_vector(residuals).squaredNorm(), damping = 1e-3;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const MatrixXd jacobian = jacobian_at(problem, parameters, residuals);
    const MatrixXd curvature = jacobian.transpose() * jacobian;
    const VectorXd gradient = jacobian.transpose() * as_vector(residuals);
    const double before = cost;
    for (; !(cost < before) && damping < most_damping; damping *= raise) {
      MatrixXd damped = curvature;
      damped.diagonal() += damping * curvature.diagonal();
      damped.diagonal().array() += 1e-12;  // held parameters have nothing else
      const Eigen::LLT<MatrixXd> factor(damped);
      if (factor.info() != Eigen::Success) continue;
      VectorXd::Map(there.data(), gradient.size()) = as_vector(parameters) - factor.solve(gradient);
      if (!problem.residuals(there, tried)) continue;
      const double reached = as_vector(tried).squaredNorm();
      if (!(reached < cost)) continue;
      parameters.swap(there);
      residuals.swap(tried);
      cost = reached;
      damping = std::max(damping / lower, least_damping) / raise;  // the loop raises it again
    }
    if (!(cost < (1 - least_gain) * before)) break;
  }
  return cost;
}

std::vector<double> curvature_at(const LeastSquares& problem, const std::vector<double>& parameters) {
  std::vector<double> residuals;
  problem.residuals(parameters, residuals);
  const MatrixXd jacobian = jacobian_at(problem, parameters, residuals);
  const MatrixXd curvature = jacobian.transpose() * jacobian;
  return {curvature.data(), curvature.data() + curvature.size()};
}

}  // namespace tactile::alignment
