#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/events/other_streams.hpp"
#include "tactile/labels/activity.hpp"
#include "tactile/labels/clock_fit.hpp"
#include "tactile/labels/event_rate.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile {

/// What is known of two clocks before any content is compared: camera_us - clock_us lies within `within` of `offset_us`.
struct CoarseOffset {
  std::int64_t offset_us = 0;
  microseconds within{};
};

/// When something of the camera came to the host.
struct CameraArrival {
  CameraTime camera{};
  HostTime host{};
};

/// What one piece of the robot's clock and one recording hold together.
struct AnchorInputs {
  const RobotLog& robot;
  const EventRate& rate;
  const QuietRate& quiet;
  std::span<const ImuSample> imu = {};  ///< none where the camera has no such sensor
  std::span<const CameraArrival> host_from_camera =
      {};                                   ///< run.json's `host_from_camera`, if it has it; with the log's host times
  std::optional<CoarseOffset> coarse = {};  ///< nothing: all lags at which log and recording overlap are looked at
};

struct AnchorOptions {
  microseconds grid{4'000};           ///< of the first search, over all lags
  double ambiguous_below = 1.2;       ///< a best match is refused that is not so many times as good as the second
  double least_likeness = 0.3;        ///< or is worse than this; 1 is perfect
  microseconds most_slack{45'000};    ///< from the lift's start until the skin shears: 1 mm of travel at 1.2 m/s^2 takes 41 ms
  microseconds stage_delay{350'000};  ///< a stage's command to its contact, in the middle of 0.05 to 0.65 s or so
};

/// How well two signals of the run lie on each other at their best lag.
struct LagMatch {
  std::int64_t offset_us = 0;  ///< camera - clock
  double likeness = 0;         ///< 0 to 1
  double ratio = 0;            ///< to the second best, infinite if there is none
};

struct FoundAnchors {
  std::vector<ClockAnchor> anchors;     ///< by kind, then time
  std::vector<std::string> doubts;      ///< each a sentence: what could not be used, and why
  std::optional<LagMatch> imu, events;  ///< the first search, where it was possible
};

/// Looks for moments that the robot's log and the recording both show, nothing being known of where one clock lies on the other:
///
/// - IMU. The TCP's acceleration is laid over the felt one at every lag (normalised cross-correlation over all axes, so that
///   neither where the sensor sits nor which way it looks needs to be known); then each stretch of motion is fitted by least
///   squares, v(t) = a + b t + c . integral of the felt acceleration, which holds whatever the rates of the two are.
/// - Sync taps and first shear. Without an IMU, the root of the event rate is laid over the root of the TCP's speed likewise.
/// Then
///   - a tap is placed where contact and release lie alike on either side of the lowest point;
///   - a lift where the rate of the first shear, as long as the tips follow the arm, grows in step with the arm's speed. It tells
///     where the speed was zero, not when the first tip moved: the slack between them is not part of it.
/// - Stage output. A rising edge comes before its contact by what the stage travels, which nobody knows to better than some
/// tenths
///   of a second; from a falling one on the tips are released.
///
/// What is ambiguous is refused and said so in `doubts`.
/// Source: Faris et al., arXiv:2403.10120, section IV, for events against the lift.
FoundAnchors clock_anchors(const AnchorInputs& inputs, const AnchorOptions& options = {});

}  // namespace tactile
