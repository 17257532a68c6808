#include "tactile/detect/robot_reporter.hpp"

#include <utility>

#include "tactile/core/host_clock.hpp"

namespace tactile::detect {

RobotReporter::RobotReporter(const RobotReporterOptions& options, ReportFault fault, std::function<void()> prepare)
    : bits_(options.rules, options.clearing) {
  robot::RobotInputsOptions inputs{.host = options.address.host, .port = options.address.port, .bits = options.registers};
  inputs.log = [fault = std::move(fault)](const std::string& text) { fault({"robot", text, host_now()}); };
  inputs.prepare = std::move(prepare);
  inputs_ = std::make_unique<robot::RobotInputs>(std::move(inputs));
}

void RobotReporter::report(const ReportedTick& tick) {
  const std::uint64_t high = bits_.next(tick.verdict.t, tick.verdict.verdict, tick.verdict.slip_is_confirmed);
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

void RobotReporter::forget() {
  const std::uint64_t high = bits_.forget();
  if (std::exchange(high_, high) != high) inputs_->set(high);
}

RobotReporterSummary RobotReporter::summary() const {
  const std::scoped_lock lock(guard_);
  return {inputs_->state(), raised_, from_event_};
}

}  // namespace tactile::detect
