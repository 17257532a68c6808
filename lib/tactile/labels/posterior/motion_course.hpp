#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/alignment/arm_motion.hpp"
#include "tactile/alignment/run_signals.hpp"
#include "tactile/labels/posterior/run_states.hpp"

namespace tactile::labels {

/// The speed of the arm against time on the robot's clock, 0 where it rests. Or, without a log, when a film shows any motion, on
/// the film's clock.
class MotionCourse {
 public:
  /// A move that returns to its start within a second, and does not lead upwards, is a sync tap.
  /// @param is_whole  the log is no piece of several
  explicit MotionCourse(const alignment::ArmMotion& motion, bool is_whole = true);
  explicit MotionCourse(const alignment::MotionEnergy& film);

  bool has_speed() const { return !speed_.empty(); }
  std::span<const float> speed() const { return speed_; }  ///< [mm/s] at begin + i * step, NaN where it is not known
  microseconds step() const { return step_; }
  RobotTime begin() const { return begin_; }  ///< of what is known
  RobotTime end() const { return end_; }
  bool moves_at_all() const { return !moves_.empty(); }

  /// In camera time, by time.
  std::vector<alignment::CameraSpan> moves_at(std::int64_t offset_us) const;

  /// How many starts and stops lie outside [first, last], if the camera's clock is ahead by `offset`.
  double changes_outside(CameraTime first, CameraTime last, std::int64_t offset_us) const;

  /// The arm's condition in each of `bins` bins from `first` on, if the camera's clock is ahead by `offset`. Beyond a
  /// whole log it rests, unless it moves where the log begins or ends; beyond a film or a piece it is not known.
  std::vector<std::uint8_t> conditions(CameraTime first, microseconds bin, std::size_t bins, std::int64_t offset_us) const;

 private:
  struct Move {
    std::int64_t start_us, end_us;            ///< on the course's own clock
    bool taps = false;                        ///< the arm goes there and straight back
    bool start_cut = false, end_cut = false;  ///< it moves where the log begins or ends
  };
  double steps_unseen(std::span<const double> speed) const;
  void add_move(std::span<const double> speed, std::size_t first);

  std::uint8_t before_ = arm_unknown, after_ = arm_unknown;  ///< conditions beyond what is known
  RobotTime begin_{}, end_{};
  microseconds step_{};
  std::vector<float> speed_;
  std::vector<Move> moves_, gaps_;  ///< by time; of the log, what is not known
};

}  // namespace tactile::labels
