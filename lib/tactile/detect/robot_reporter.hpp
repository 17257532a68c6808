#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "tactile/detect/deadline_monitor.hpp"
#include "tactile/detect/detection_fault.hpp"
#include "tactile/detect/reported_tick.hpp"
#include "tactile/detect/robot_bits.hpp"
#include "tactile/robot/robot_inputs.hpp"
#include "tactile/transport/network_address.hpp"

namespace tactile::detect {

struct RobotReporterOptions {
  transport::NetworkAddress address;
  std::vector<int> registers;       ///< input bit registers, 64 to 127
  std::vector<RobotBitRule> rules;  ///< one for each register
  BitClearing clearing;
};

struct RobotReporterSummary {
  robot::RobotInputsState state;
  std::uint64_t raised = 0;      ///< how often a bit rose
  DurationHistogram from_event;  ///< of rising bits: from the arrival of the last event to the write of the register
};

/// Writes verdicts to the bit registers of a robot.
class RobotReporter {
 public:
  /// @param prepare  called first on the thread that writes to the robot
  RobotReporter(const RobotReporterOptions& options, ReportFault fault, std::function<void()> prepare);

  void report(const ReportedTick& tick);
  void forget();  ///< no verdict is known until the next tick
  RobotReporterSummary summary() const;

 private:
  RobotBits bits_;
  std::uint64_t high_ = 0, raised_ = 0;
  mutable std::mutex guard_;
  DurationHistogram from_event_;
  std::unique_ptr<robot::RobotInputs> inputs_;  ///< last, so that its thread ends first
};

}  // namespace tactile::detect
