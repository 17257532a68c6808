#include "robot_teller.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "source_arguments.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"

namespace tactile {

RobotBitsAskedFor bits_asked_for(const RobotArguments& args) {
  RobotBitsAskedFor asked;
  const auto add = [&asked](const std::optional<int>& bit, const RobotBitRule& rule) {
    if (!bit) return;
    asked.bits.push_back(*bit);
    asked.rules.push_back(rule);
  };
  add(args.bit, {.at_press = true, .at_slip = true});
  add(args.press_bit, {.at_press = true, .at_slip = false});
  add(args.slip_bit, {.at_press = false, .at_slip = true});
  // Here, and not by CLI11: each may stand on the command line or in --config's file.
  if (args.host.empty()) {
    const std::array<std::pair<bool, const char*>, 5> of_a_robot{{{args.bit.has_value(), "--bit"},
                                                                  {args.press_bit.has_value(), "--press-bit"},
                                                                  {args.slip_bit.has_value(), "--slip-bit"},
                                                                  {args.latch, "--latch"},
                                                                  {args.clear_ms.has_value(), "--clear-ms"}}};
    for (const auto& [given, option] : of_a_robot) {
      if (!given) continue;
      throw Error(fmt::format("{}: there is no robot to tell, --robot is missing; expected --robot HOST beside it{}", option,
                              asked.bits.empty() ? ", and --bit, --press-bit or --slip-bit with a register from 64 to 127" : ""));
    }
  }
  if (asked.bits.empty() && !args.host.empty())
    throw Error("--robot: there is no bit to tell it; expected --bit, --press-bit or --slip-bit with a register from 64 to 127");
  if (args.latch && args.clear_ms) throw Error("--latch: does not go with --clear-ms; expected one of the two");
  for (std::size_t i = 0; i < asked.bits.size(); ++i) {
    if (std::find(asked.bits.begin(), asked.bits.begin() + static_cast<std::ptrdiff_t>(i), asked.bits[i]) !=
        asked.bits.begin() + static_cast<std::ptrdiff_t>(i))
      throw Error(fmt::format("--bit: register {} stands for two things; expected another one for each", asked.bits[i]));
  }
  return asked;
}

RobotTeller::RobotTeller(const RobotArguments& args, const RobotBitsAskedFor& asked, TellFault fault,
                         std::function<void()> prepare)
    : bits_(asked.rules, {.never = args.latch, .hold = microseconds{std::llround(1000 * args.clear_ms.value_or(0))}}) {
  const NetworkAddress address = robot_address(args.host);
  RobotInputsOptions options{.host = address.host, .port = address.port, .bits = asked.bits};
  options.log = [fault = std::move(fault)](const std::string& text) { fault({"robot", text, host_now()}); };
  options.prepare = std::move(prepare);
  inputs_ = std::make_unique<RobotInputs>(std::move(options));
}

void RobotTeller::tell(const ToldTick& tick) {
  const std::uint64_t high = bits_.next(tick.verdict.t, tick.verdict.verdict);
  const bool rises = (high & ~high_) != 0;
  if (high == high_) return;
  high_ = high;
  if (!rises) return inputs_->set(high);
  ++raised_;
  inputs_->set(high, [this, event = tick.last_arrival.value_or(tick.due.closed)] {
    const std::scoped_lock lock(guard_);
    from_event_.add(host_now() - event);
  });
}

void RobotTeller::forget() {
  const std::uint64_t high = bits_.forget();
  if (std::exchange(high_, high) != high) inputs_->set(high);
}

ToldToRobot RobotTeller::summary() const {
  const std::scoped_lock lock(guard_);
  return {inputs_->state(), raised_, from_event_};
}

}  // namespace tactile
