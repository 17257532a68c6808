#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace tactile {

/// The arm as a mass on a spring: each change c of its acceleration makes it lag and swing,
///
///   x'(u) = -share c / w e^(-u / decay_s) sin(w u),   w = 2 pi hz,   u seconds after the change
struct ArmRinging {
  double hz = 0;
  double decay_s = 0;
  double share = 0;  ///< of the acceleration, that it swings with at first
};

/// A TCP speed as controllers command it, straight lines from knot to knot, and the arm's ringing on top of it.
struct SpeedProfile {
  using Speed = std::array<double, 3>;  ///< [m/s]

  std::vector<double> knots_s;  ///< ascending; at least 3
  std::vector<Speed> speeds;    ///< commanded at the knots, one each
  ArmRinging ringing;
  bool open_begin = false;         ///< the arm moved before the first knot, of which nothing is known
  bool open_end = false;           ///< it moves on behind the last knot
  std::vector<double> covariance;  ///< of the knots [s^2], row by row; 0 for those of an open end
  double speed_sigma = 0;          ///< [m/s] of a row against the profile, each axis

  Speed commanded_at(double t_s) const;  ///< 0 outside of the knots
  Speed ringing_at(double t_s) const;
  double sigma_s(std::size_t knot) const;
};

/// A row's time and speed.
struct SpeedRow {
  double t_s = 0;
  SpeedProfile::Speed speed{};
};

struct SpeedProfileOptions {
  double noise = 1e-4;                  ///< [m/s] standard deviation of each axis of a row, at rest
  double smoothed_s = 0;                ///< each row's speed is the mean over so long to either side of its time
  std::vector<double> knots_s{};        ///< roughly where the commanded acceleration changes; at least 3, ascending
  std::vector<double> other_knots_s{};  ///< likewise, if the first do not do; or none
  bool open_begin = false;
  bool open_end = false;
  std::optional<ArmRinging> ringing{};  ///< of an earlier motion of the arm: looked for there first
  std::size_t most_knots = 10;          ///< may be added to, while the rows ask for it
};

/// Fits the profile that a stretch of motion follows: knots, speeds and ringing by least squares, single rows that lie far off
/// (which recorders make of two packages) counting less. Knots are added where the straight lines do not do. A knot's variance
/// comes from the curvature of the squares, scaled by how far the rows really lie from the profile and by how alike neighbours
/// err.
///
/// @param rows  of the stretch, with the rest before it and the ring-down after it; ascending
/// @return      nothing if there are too few rows, or if no profile fits
std::optional<SpeedProfile> fit_speed_profile(std::span<const SpeedRow> rows, const SpeedProfileOptions& options);

}  // namespace tactile
