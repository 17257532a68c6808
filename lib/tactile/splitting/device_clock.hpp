#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tactile/alignment/activity.hpp"
#include "tactile/alignment/anchor_search.hpp"
#include "tactile/alignment/event_rate.hpp"
#include "tactile/core/clock_relation.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/splitting/split_source.hpp"
#include "tactile/splitting/touches.hpp"

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
  /// Of a robot with a clock: the lifts and taps of the arm. Nothing if they are not known.
  std::optional<std::vector<ArmMove>> lifts = {}, taps = {};
};

/// All samples of the IMU of an event stream's camera, by time.
std::vector<events::ImuSample> imu_of(events::RecordingReader& recording, std::int32_t event_stream);

/// The robot's clock, and the arm's motions. In this order: host times of log and camera; labels that were made of the whole
/// recording; the log's motions against the recording (`clock_anchors`). A log whose clock
/// restarts is related by host times only.
/// @param rate, quiet  of the event stream
/// @throws Error  if the log cannot be read
DeviceClockSearch find_robot_clock(const SplitSource& source, events::RecordingReader& recording, std::int32_t event_stream,
                                   const alignment::EventRate& rate, const alignment::QuietRate& quiet);

/// The film's clock: by host times, or by labels of the whole recording.
DeviceClockSearch find_film_clock(const SplitSource& source);

}  // namespace tactile::splitting
