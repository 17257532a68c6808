#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "tactile/robot/robot_log.hpp"

namespace tactile {

/// The arm's motion on an even grid of its own clock, between the rows of its log and beyond none.
struct ArmMotion {
  RobotTime begin{};
  microseconds step{4'000};
  std::vector<std::array<double, 3>> velocity;      ///< of the TCP at begin + i * step, base frame [m/s]
  std::vector<std::array<double, 3>> acceleration;  ///< mean from that point to the next [m/s^2]; 0 at the last
  std::vector<bool> known;                          ///< false within a gap, where the others are 0

  RobotTime time_of(std::size_t i) const { return begin + step * static_cast<std::int64_t>(i); }
};

struct ArmMotionOptions {
  microseconds step{4'000};             ///< > 0
  microseconds longest_gap{100'000};    ///< rows further apart have a gap between them, even if the log names none
  std::size_t most_points = 1U << 22U;  ///< a log that would need more is not resampled: 4.6 h at 4 ms
};

/// TCP speeds, by straight lines between the rows. Nothing if the log has fewer than two rows or would need more points than
/// allowed.
std::optional<ArmMotion> arm_motion(const RobotLog& log, const ArmMotionOptions& options = {});

/// How an arm that was told to move along a straight line moves: its acceleration c changes in steps c_k at the times t_k, and at
/// each step the arm, which is a mass on a spring, begins to ring,
///
///   v(t) = sum over t_k < t of c_k (t - t_k - ringing_share e^(-d (t - t_k)) sin(w (t - t_k)) / w),
///   w = 2 pi ringing_hz,  d = 1 / ringing_decay_s
struct CommandedMotion {
  enum class Kind : std::uint8_t {
    one_way,         ///< a lift, or a lowering: comes to rest elsewhere
    there_and_back,  ///< a tap: comes to rest where it started
  };
  Kind kind = Kind::one_way;
  RobotTime begin{};                    ///< of the fit: what times below count from
  std::array<double, 3> direction{};    ///< unit vector in the base frame, of the first half of the motion
  std::array<double, 4> change_s{};     ///< t_k, ascending
  std::array<double, 4> change_m_s2{};  ///< c_k; their sum is 0
  double ringing_share = 0;             ///< 0 where none is seen
  double ringing_hz = 0, ringing_decay_s = 0;
  double sigma_s = 0;     ///< standard deviation of its place in time, noise of the log and misfit of the model
  double misfit_m_s = 0;  ///< root mean square of what the model does not explain

  RobotTime time_at(double since_s) const {
    return begin + microseconds(std::int64_t(since_s * 1e6 + (since_s < 0 ? -0.5 : 0.5)));
  }
  RobotTime start() const { return time_at(change_s.front()); }
  RobotTime end() const { return time_at(change_s.back()); }
  double told_m_s(double since_s) const;   ///< commanded speed along `direction`, without the ringing
  double speed_m_s(double since_s) const;  ///< with it
  double turn_s() const;                   ///< of a there-and-back: when the commanded speed passes zero
};

/// Each stretch of straight motion of the log that lies whole between two rests and in no gap, by time. Least squares on the
/// TCP's speeds with the ringing in the model: a line through the rise of a speed that rings comes out up to 4 ms late. Motions
/// that the model does not explain are left out: what it leaves must be below a tenth of the peak speed.
std::vector<CommandedMotion> commanded_motions(const RobotLog& log);

}  // namespace tactile
