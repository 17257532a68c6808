#pragma once

#include <optional>
#include <string>

#include "options.hpp"
#include "tactile/detect/robot_reporter.hpp"

namespace tactile::cli {

/// The options of a robot that `detect` reports to.
struct RobotArguments {
  std::string host;  ///< HOST[:PORT]; empty: none
  std::optional<int> bit, press_bit, slip_bit, confirmed_bit;
  std::optional<double> clear_ms;
  bool latch = false;
};

/// @param args  must outlive the command
void add_robot_options(Command& command, RobotArguments& args);

/// Nothing without --robot.
/// @throws Error  that names the option, if a bit has no robot, a robot no bit, or two options contradict each other
std::optional<detect::RobotReporterOptions> robot_options(const RobotArguments& args);

}  // namespace tactile::cli
