#pragma once

#include <cstdint>
#include <vector>

#include "tactile/alignment/arm_motion.hpp"
#include "tactile/labels/posterior/run_states.hpp"

namespace tactile::labels {

/// The speed of the arm against time on the robot's clock, 0 where it rests.
class ArmCourse {
 public:
  explicit ArmCourse(const alignment::ArmMotion& motion);

  RobotTime begin() const { return begin_; }  ///< of what is known
  RobotTime end() const { return end_; }
  bool moves_at_all() const { return !moves_.empty(); }

  /// The arm's condition in each of `bins` bins from `first` on, if the camera's clock is ahead of the robot's by `offset`.
  std::vector<std::uint8_t> conditions(CameraTime first, microseconds bin, std::size_t bins, std::int64_t offset_us) const;

 private:
  struct Move {
    std::int64_t start_us, end_us;  ///< on the robot's clock
  };
  void add_move(const std::vector<double>& speed, std::size_t first, std::size_t last, double moving);

  RobotTime begin_{}, end_{};
  microseconds step_{};
  std::vector<float> speed_;  ///< [mm/s] at begin + i * step
  std::vector<Move> moves_;
};

}  // namespace tactile::labels
