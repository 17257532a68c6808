#include "tactile/alignment/least_squares.hpp"

#include <Eigen/Core>
#include <limits>
#include <unsupported/Eigen/NonLinearOptimization>
#include <utility>

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

/// The problem as Eigen takes it.
class EigenProblem {
 public:
  EigenProblem(const LeastSquares& problem, std::vector<double> parameters, std::vector<double> residuals)
      : problem_(problem), at_(std::move(parameters)), residuals_(std::move(residuals)) {}

  Eigen::Index values() const { return as_vector(residuals_).size(); }

  /// Eigen ends where this fails. Residuals beyond all others make it shorten its step instead.
  int operator()(const VectorXd& parameters, VectorXd& residuals) {
    std::vector<double> there;
    const bool is_possible = evaluate(parameters, there);
    residuals = is_possible ? VectorXd(as_vector(there)) : VectorXd::Constant(values(), 1e100);
    return 0;
  }

  int df(const VectorXd& parameters, MatrixXd& jacobian) {
    std::vector<double> there;
    evaluate(parameters, there);
    jacobian = jacobian_at(problem_, at_, there);
    return 0;
  }

 private:
  bool evaluate(const VectorXd& parameters, std::vector<double>& residuals) {
    std::vector<double> at(parameters.data(), parameters.data() + parameters.size());
    if (at == at_) {
      residuals = residuals_;
      return true;
    }
    if (!problem_.residuals(at, residuals)) return false;
    at_ = std::move(at);
    residuals_ = residuals;
    return true;
  }

  const LeastSquares& problem_;
  std::vector<double> at_, residuals_;  ///< the last possible parameters that were asked for
};

}  // namespace

double descend(const LeastSquares& problem, std::vector<double>& parameters, int iterations) {
  std::vector<double> residuals;
  if (!problem.residuals(parameters, residuals)) return std::numeric_limits<double>::infinity();
  constexpr double least_gain = 1e-6;
  EigenProblem function(problem, parameters, residuals);
  Eigen::LevenbergMarquardt<EigenProblem> descent(function);
  descent.parameters.ftol = least_gain;
  descent.parameters.xtol = 1e-12;
  VectorXd at = as_vector(parameters);
  auto status = descent.minimizeInit(at);
  if (status != Eigen::LevenbergMarquardtSpace::NotStarted)
    return as_vector(residuals).squaredNorm();  // more parameters than values
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const double before = descent.fnorm * descent.fnorm;
    status = descent.minimizeOneStep(at);
    if (status != Eigen::LevenbergMarquardtSpace::Running || !(descent.fnorm * descent.fnorm < (1 - least_gain) * before)) break;
  }
  parameters.assign(at.data(), at.data() + at.size());
  return descent.fnorm * descent.fnorm;
}

std::vector<double> curvature_at(const LeastSquares& problem, const std::vector<double>& parameters) {
  std::vector<double> residuals;
  problem.residuals(parameters, residuals);
  const MatrixXd jacobian = jacobian_at(problem, parameters, residuals);
  const MatrixXd curvature = jacobian.transpose() * jacobian;
  return {curvature.data(), curvature.data() + curvature.size()};
}

}  // namespace tactile::alignment
