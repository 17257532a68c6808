#include "robot_arguments.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "option_checks.hpp"
#include "source_arguments.hpp"
#include "tactile/core/error.hpp"

namespace tactile::cli {

void add_robot_options(Command& command, RobotArguments& args) {
  command.add_option("--robot", args.host, "UR controller to report to").type_name("HOST[:PORT]");
  const Check is_bit = in_range(64, 127);
  command.add_option("--bit", args.bit, "Input bit register to set at press and at slip").check(is_bit).type_name("N");
  command.add_option("--press-bit", args.press_bit, "Input bit register to set at press only").check(is_bit).type_name("N");
  command.add_option("--slip-bit", args.slip_bit, "Input bit register to set at slip only").check(is_bit).type_name("N");
  command.add_option("--confirmed-bit", args.confirmed_bit, "Input bit register to set at a slip that is confirmed")
      .check(is_bit)
      .type_name("N");
  const Option latch = command.add_flag("--latch", args.latch, "Keep a bit high until the end once it is set");
  command.add_option("--clear-ms", args.clear_ms, "Clear a bit this long after the last tick that set it [ms]")
      .check(in_range(0.0, 1e6))
      .excludes(latch)
      .default_text("0");
}

/// CLI11 cannot check this, because each option may come from the command line or from --config's file.
std::optional<detect::RobotReporterOptions> robot_options(const RobotArguments& args) {
  detect::RobotReporterOptions robot;
  const auto add = [&robot](const std::optional<int>& bit, const detect::RobotBitRule& rule) {
    if (!bit) return;
    robot.registers.push_back(*bit);
    robot.rules.push_back(rule);
  };
  add(args.bit, {.at_press = true, .at_slip = true});
  add(args.press_bit, {.at_press = true, .at_slip = false});
  add(args.slip_bit, {.at_press = false, .at_slip = true});
  add(args.confirmed_bit, {.at_press = false, .at_slip = false, .at_confirmed_slip = true});
  if (args.host.empty()) {
    const std::array<std::pair<bool, const char*>, 6> options{{{args.bit.has_value(), "--bit"},
                                                               {args.press_bit.has_value(), "--press-bit"},
                                                               {args.slip_bit.has_value(), "--slip-bit"},
                                                               {args.confirmed_bit.has_value(), "--confirmed-bit"},
                                                               {args.latch, "--latch"},
                                                               {args.clear_ms.has_value(), "--clear-ms"}}};
    for (const auto& [given, option] : options) {
      if (!given) continue;
      throw Error(fmt::format("{}: --robot is missing; expected --robot HOST too{}", option,
                              robot.registers.empty()
                                  ? ", and --bit, --press-bit, --slip-bit or --confirmed-bit with a register from 64 to 127"
                                  : ""));
    }
    return std::nullopt;
  }
  if (robot.registers.empty())
    throw Error(
        "--robot: no bit is given; expected --bit, --press-bit, --slip-bit or --confirmed-bit with a register from 64 to 127");
  if (args.latch && args.clear_ms) throw Error("--latch: cannot be used with --clear-ms; expected one of the two");
  for (auto bit = robot.registers.begin(); bit != robot.registers.end(); ++bit) {
    if (std::find(robot.registers.begin(), bit, *bit) != bit)
      throw Error(fmt::format("--bit: register {} is given twice; expected a different one for each option", *bit));
  }
  robot.address = robot_address(args.host);
  robot.clearing = {.never = args.latch, .hold = microseconds{std::llround(1000 * args.clear_ms.value_or(0))}};
  return robot;
}

}  // namespace tactile::cli
