#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "tactile/detect/tick_clock.hpp"
#include "tactile/detect/tick_detector.hpp"

namespace tactile::detect {

/// A tick with its verdict.
struct ReportedTick {
  TickVerdict verdict;
  DueTick due;
  std::uint64_t number = 0;     ///< index among the reported ticks
  std::uint32_t beginning = 0;  ///< restarts of the stream so far: no verdict has events from before and after a restart
  CameraTime first_event{};     ///< of the stream since its last restart: the origin of times for people
  bool incomplete = false;      ///< events of its history are known to be lost
  std::uint64_t late_events = 0, lost_events = 0;  ///< so far, as `LiveCounts`
  HostTime begun{};                                ///< when its processing began
  std::optional<HostTime> last_arrival;            ///< of any events
  /// From when the tick could first be reported until it has its verdict; nothing in a replay, whose ticks have no deadline.
  std::optional<std::chrono::nanoseconds> lateness;
};

}  // namespace tactile::detect
