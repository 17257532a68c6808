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
  explicit MotionCourse(const alignment::ArmMotion& motion);
  explicit MotionCourse(const alignment::MotionEnergy& film);

  bool is_of_film() const { return speed_.empty(); }
  RobotTime begin() const { return begin_; }  ///< of what is known
  RobotTime end() const { return end_; }
  bool moves_at_all() const { return !moves_.empty(); }

  /// In camera time, by time.
  std::vector<alignment::CameraSpan> moves_at(std::int64_t offset_us) const;

  /// Whether nothing moves within [first, last], nor has just stopped.
  bool rests_in(CameraTime first, CameraTime last, std::int64_t offset_us) const;

  /// How many starts and stops lie outside [first, last], if the camera's clock is ahead by `offset`.
  double changes_outside(CameraTime first, CameraTime last, std::int64_t offset_us) const;

  /// The arm's condition in each of `bins` bins from `first` on, if the camera's clock is ahead by `offset`.
  std::vector<std::uint8_t> conditions(CameraTime first, microseconds bin, std::size_t bins, std::int64_t offset_us) const;

 private:
  struct Move {
    std::int64_t start_us, end_us;  ///< on the course's own clock
  };
  double steps_unseen(std::span<const double> speed) const;
  void add_move(std::span<const double> speed, std::size_t first);

  RobotTime begin_{}, end_{};
  microseconds step_{};
  std::vector<float> speed_;  ///< [mm/s] at begin + i * step
  std::vector<Move> moves_;
};

}  // namespace tactile::labels
