#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "tactile/alignment/vector3.hpp"

namespace tactile::alignment {

/// The arm as a mass on a spring: after each change c of its acceleration it lags and rings with the speed
///
///   x'(u) = -share c / w e^(-u / decay_s) sin(w u),   w = 2 pi hz,   u seconds after the change
struct ArmRinging {
  double hz = 0;
  double decay_s = 0;
  double share = 0;  ///< of the acceleration, at first
};

/// The model of an arm's motion: the TCP speed as controllers command it, straight lines from knot to knot, and the ringing of
/// the arm in addition.
struct SpeedProfile {
  using Speed = Vector3;  ///< [m/s]

  std::vector<double> knots_s;  ///< ascending; at least 3
  std::vector<Speed> speeds;    ///< commanded, one per knot
  ArmRinging ringing;
  bool open_begin = false;         ///< the arm moved before the first knot; nothing is known of that
  bool open_end = false;           ///< it moves on after the last knot
  std::vector<double> covariance;  ///< of the knots [s^2], row by row; 0 for those of an open end
  double speed_sigma = 0;          ///< [m/s] of a row against the profile, each axis

  Speed commanded_at(double t_s) const;  ///< 0 outside the knots
  Speed ringing_at(double t_s) const;
  double commanded_m_s(double t_s) const { return length_of(commanded_at(t_s)); }
  double speed_m_s(double t_s) const;  ///< of command and ringing together
  double sigma_s(std::size_t knot) const;
  /// Whether the ringing after the greatest change of the acceleration exceeds three standard deviations of a row.
  bool rings() const;
  /// Adds a profile that begins after this one ends.
  void append(const SpeedProfile& later);

 private:
  Vector3 change_at(std::size_t knot) const;  ///< of the commanded acceleration [m/s^2]; 0 at open ends
};

/// A row's time and speed.
struct SpeedRow {
  double t_s = 0;
  SpeedProfile::Speed speed{};
};

struct SpeedProfileOptions {
  double noise = 1e-4;                  ///< [m/s] standard deviation of each axis of a row, at rest
  double smoothed_s = 0;                ///< each row's speed is the mean over this time on either side of it
  std::vector<double> knots_s{};        ///< rough times at which the commanded acceleration changes; at least 3, ascending
  std::vector<double> other_knots_s{};  ///< tried if the first do not fit; or none
  bool open_begin = false;
  bool open_end = false;
  std::optional<ArmRinging> ringing{};  ///< of an earlier motion of the arm: tried first
  std::size_t most_knots = 10;          ///< knots are added up to this number while the rows need them
};

/// Fits the profile of a stretch of motion: knots, speeds and ringing by least squares. Single rows that lie far off weigh less;
/// recorders make such rows of two packages. Knots are added where straight lines do not fit. A knot's variance follows from the
/// curvature of the squares, scaled by the residuals of the rows and by the correlation of neighbouring residuals.
///
/// @param rows  of the stretch, with the rest before it and the ringing after it; ascending
/// @return      nothing if there are too few rows, or if no profile fits
std::optional<SpeedProfile> fit_speed_profile(std::span<const SpeedRow> rows, const SpeedProfileOptions& options);

}  // namespace tactile::alignment
