#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/core/clock_relation.hpp"
#include "tactile/core/time.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/splitting/split_source.hpp"

namespace tactile::splitting {

/// Where a device's data lie in camera time, well enough to cut them with some margin.
struct DeviceClock {
  /// By the rows' host times: when data of the camera arrived at the same host. Empty: by the device's own stamps.
  std::vector<alignment::CameraArrival> arrivals{};
  ClockRelation relation{};  ///< of the device's stamps, if there are no arrivals
  microseconds within{};     ///< the relation may be off by so much
  std::string how;           ///< what it follows from, for a person: "host times"

  bool is_by_host() const { return !arrivals.empty(); }
  /// A camera time on the host's clock, or on the device's [us].
  std::int64_t device_us_at(CameraTime t) const;
  /// The inverse. @param us  on the host's clock, or on the device's
  CameraTime camera_at(std::int64_t us) const;
};

/// A device's clock, or why it is not known.
struct DeviceClockSearch {
  std::optional<DeviceClock> clock;
  std::string why_not = {};  ///< a sentence without its end; empty if there is a clock, or no device
};

/// The robot's clock, before the log's motions are compared with the recording: by host times of log and camera, or by labels
/// that were made of the whole recording. A log whose clock restarts is related by host times only. @param log  of `source`
DeviceClockSearch known_robot_clock(const SplitSource& source, const robot::RobotLogFile& log);

/// How far the camera's clock is ahead of the robot's around a time. @param clock  of a robot  @param log  a piece of its log
alignment::CoarseOffset offset_around(const DeviceClock& clock, const robot::RobotLog& log, CameraTime t);

/// The film's clock: by host times, or by labels of the whole recording.
DeviceClockSearch find_film_clock(const SplitSource& source);

}  // namespace tactile::splitting
