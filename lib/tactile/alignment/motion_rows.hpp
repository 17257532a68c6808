#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "tactile/alignment/speed_profile.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::alignment {

/// Standard deviation of each axis of the TCP's speed at rest [m/s]: from the differences of speeds 24 ms apart, which slow
/// changes hardly affect. 0 with less than 8 rows.
double speed_noise(const robot::RobotLog& log);

/// The TCP speeds of a log, and where the arm moves in them: the one division of a log into motion and rest.
///
/// A row moves if its speed is at least `slowest` and five standard deviations above the median of the noise. After a motion that
/// rings, for 0.3 s, it must also have a tenth of that motion's peak speed.
class MotionRows {
 public:
  /// @param log  with one row at least
  /// @param slowest  [m/s] > 0
  MotionRows(const robot::RobotLog& log, double slowest);

  const std::vector<SpeedRow>& rows() const { return rows_; }  ///< less what was explained; times in seconds from the first row
  std::size_t size() const { return rows_.size(); }
  double t_s(std::size_t row) const { return rows_[row].t_s; }
  double speed(std::size_t row) const;  ///< its size [m/s]
  double noise() const { return noise_; }
  double limit() const { return limit_; }        ///< [m/s] a slower row rests
  double period_s() const { return period_s_; }  ///< usual time from row to row

  bool moves(std::size_t row) const;
  bool gap_before(std::size_t row) const { return row > 0 && rows_[row].t_s - rows_[row - 1].t_s > longest_step_s; }
  std::size_t row_at_or_after(double t_s) const;

  /// The row after the last one of the stretch of motion that begins at `begin`. It may pause for 60 ms, and ends at a gap.
  std::size_t stretch_end(std::size_t begin) const;
  /// Where the rest before `row` begins: at the end of the last motion, at a gap, or 0.15 s before it [s].
  double rest_begin_s(std::size_t row) const;
  /// Where the ringing after row `end` ends: before the next motion of at least `least_m`, at a gap, or `tail_s` after it [s].
  double tail_end_s(std::size_t end, double least_m, double tail_s) const;

  /// A motion ended here; what follows is not its rest.
  void end_motion(double t_s) { explained_until_s_ = t_s; }
  /// Takes a fitted motion off the rows from its first knot on, so that its ringing is no motion.
  void subtract(const SpeedProfile& profile, double stop_s, double peak_speed);

 private:
  static constexpr double longest_step_s = 0.1;  // longer ones are gaps

  std::vector<SpeedRow> rows_;
  double noise_ = 0, limit_ = 0, period_s_ = 0.008;
  double explained_until_s_ = -std::numeric_limits<double>::infinity();
  double ringing_until_s_ = -std::numeric_limits<double>::infinity(), ringing_limit_ = 0;
};

}  // namespace tactile::alignment
