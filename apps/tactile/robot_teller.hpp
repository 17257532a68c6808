#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "detect_report.hpp"
#include "tactile/detect/live_detector.hpp"
#include "tactile/detect/robot_bits.hpp"
#include "tactile/robot/robot_inputs.hpp"

namespace tactile {

/// What the user wants a robot to be told.
struct RobotArguments {
  std::string host;  ///< HOST[:PORT]; empty: there is none
  std::optional<int> bit, press_bit, slip_bit;
  std::optional<double> clear_ms;
  bool latch = false;
};

/// The bits that were asked for, and what raises each.
struct RobotBitsAskedFor {
  std::vector<int> bits;
  std::vector<RobotBitRule> rules;
};

/// @throws Error  that names the option, if a bit has no robot, a robot no bit, or two options contradict each other
RobotBitsAskedFor bits_asked_for(const RobotArguments& args);

/// Tells the robot, and how long that took.
class RobotTeller {
 public:
  /// @param prepare  done first on the thread that writes to the robot
  RobotTeller(const RobotArguments& args, const RobotBitsAskedFor& asked, TellFault fault, std::function<void()> prepare);

  void tell(const ToldTick& tick);
  void forget();  ///< no verdict is known until the next tick
  ToldToRobot summary() const;

 private:
  RobotBits bits_;
  std::uint64_t high_ = 0, raised_ = 0;
  mutable std::mutex guard_;
  DurationHistogram from_event_;
  std::unique_ptr<RobotInputs> inputs_;  ///< its thread ends first
};

}  // namespace tactile
