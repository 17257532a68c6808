#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "tactile/alignment/least_squares.hpp"
#include "tactile/alignment/speed_profile.hpp"

namespace tactile::alignment {

/// Speeds of the log's rows: 1 or 3 axes of each.
using SpeedMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

double usual_step_s(const std::vector<double>& times);

constexpr double faded = 12.0;          ///< decays after which nothing of a ringing is left
constexpr double fastest_seen = 0.45;   ///< periods of a ringing from row to row: a faster one is not seen
constexpr double usual_decay_s = 0.08;  ///< of a ringing, before one is seen
constexpr double usual_share = 0.2;     ///< of a ringing, before one is seen

/// The least-squares problem of a speed profile. Its parameters are the knots, then log w, log decay and the log-odds of the
/// ringing's share. The commanded speeds follow from them by linear least squares.
class SpeedProfileFit {
 public:
  /// @param times, values  of the rows; they outlive this
  SpeedProfileFit(const std::vector<double>& times, const SpeedMatrix& values, const SpeedProfileOptions& options);

  void set_knots(std::size_t knots);
  std::vector<double> parameters_of(const std::vector<double>& knots, const ArmRinging& ringing) const;
  ArmRinging ringing_of(std::span<const double> parameters) const;

  /// Descends from `parameters` and sets the best speeds there. @return the sum of squares reached
  double descend(std::vector<double>& parameters, int iterations);
  /// Weighs rows less, the farther they lie beyond three times the usual distance.
  void weigh_rows();
  /// Mean square of a row and axis over that of the noise, at the last parameters.
  double misfit() const;
  double misfit_at(const std::vector<double>& parameters);
  /// Factor by which correlated neighbours widen a variance: (1 + r) / (1 - r), with r the correlation from row to row.
  double correlation_factor() const;
  /// Of the knots, row by row, from the curvature at the parameters; empty if that is singular.
  std::vector<double> covariance_at(const std::vector<double>& parameters);
  double speed(std::size_t knot, std::size_t axis) const;

 private:
  /// How the rows ring after a change of 1 at a knot, and for which parameters that was computed.
  struct Response {
    double at_s = std::numeric_limits<double>::infinity(), w = 0, decay_s = 0;
    std::vector<double> of_rows;
  };

  bool is_held(std::size_t knot) const { return (knot == 0 && open_begin_) || (knot + 1 == knots_ && open_end_); }
  double degrees_of_freedom() const;
  LeastSquares problem();
  bool residuals_of(std::span<const double> parameters, std::vector<double>& residuals);
  bool fit_speeds(std::span<const double> parameters);
  void update_responses(std::span<const double> knots, double w, double decay_s);
  void fill_basis(std::span<const double> knots, double w, double decay_s, double share);
  double command_at(std::span<const double> knots, std::size_t knot, double t) const;
  double command_displacement(std::span<const double> knots, std::size_t knot, double t) const;

  const std::vector<double>& times_;
  const SpeedMatrix& values_;
  double noise_, smoothed_s_;
  bool open_begin_, open_end_;
  double most_log_w_;
  std::size_t knots_ = 0;
  std::vector<std::size_t> free_;  ///< knots that have a speed: all but the ends that rest
  Eigen::VectorXd weights_;
  Eigen::MatrixXd speeds_;           ///< of the free knots
  SpeedMatrix basis_, residuals_;    ///< what a speed of 1 at each free knot adds to the rows; what the last speeds leave of them
  std::vector<Response> responses_;  ///< by knot
};

}  // namespace tactile::alignment
