#pragma once

#include <chrono>
#include <optional>

#include "tactile/core/time.hpp"

namespace tactile::detect {

/// When the network runs once without use, so that its weights are in the cache for the next tick. It runs about halfway between
/// the last tick and the packet that closes the next one: a later run is more likely to stay in the cache, but on a cold cache
/// it takes up to twice as long, and packets do not arrive exactly on time.
class Rehearsal {
 public:
  /// Plans a run between two ticks. There is none if rendering and network take too large a part of a tick.
  /// @param expected  when the packet that closes the next tick is expected
  /// @param taken     by rendering and network of the last tick
  void plan(HostTime expected, microseconds taken, HostTime begun) {
    const HostTime from = expected - 4 * taken;
    if (from > begun + taken) planned_ = {from, expected - 5 * taken / 2};
  }
  void cancel() { planned_.reset(); }

  /// When the planned run begins, if that is after `now`.
  std::optional<HostTime> begins_after(HostTime now) const {
    return planned_ && planned_->from > now ? std::optional(planned_->from) : std::nullopt;
  }
  /// Whether to run now. Ends the plan once its time has come.
  bool is_due(HostTime now) {
    if (!planned_ || now < planned_->from) return false;
    const bool in_time = now < planned_->to;
    planned_.reset();
    return in_time;
  }

 private:
  struct Period {
    HostTime from{}, to{};
  };
  std::optional<Period> planned_;
};

}  // namespace tactile::detect
