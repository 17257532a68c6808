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
  /// run.json's `host_from_camera`, where it has it: with host times in the log they relate the two.
  std::span<const CameraArrival> host_from_camera = {};
  std::optional<CoarseOffset> coarse = {};  ///< nothing: all lags at which log and recording overlap are looked at
};

struct AnchorOptions {
  microseconds grid{4'000};           ///< of the first search, over all lags; whole milliseconds
  double ambiguous_below = 1.2;       ///< a best match is refused that is not so many times as good as the second
  double least_likeness = 0.3;        ///< of the IMU: or is worse than this; 1 is perfect
  double most_slack_m = 1e-3;         ///< of skin and object: so far the arm may go before anything shears
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
///   neither where the sensor sits nor which way it looks needs to be known). Then each stretch of motion is fitted by least
///   squares, v(t) = a + b t + c . integral of the felt acceleration, which holds whatever the rates of the two are.
/// - Without an IMU, where the skin is active is laid over where the arm moves likewise. What speaks for a lag besides is a first
///   shear at the lift's start, a skin that rests after the last motion, and activity that follows each command to the stage.
/// - Sync taps, each placed by its lowest point, where speed and rate are nothing between contact and release.
/// - First shear of a lift: as long as the tips follow the arm the rate grows in step with the arm's speed, which tells when the
///   speed was zero, not when the first tip moved: the slack between the two is not part of it. Where the shear is too short for
///   that, the lift began up to 0.5 mm of slack ahead of the onset, and the anchor is as wide.
/// - Ring-down after a lift's stop, where the rate follows the ringing of the log beyond doubt.
/// - Stage output. A rising edge comes ahead of its contact by the stage's travel, which nobody knows to better than some tenths
///   of a second; from a falling one on the tips are released.
/// - Host times, where rows of the log and elements of the camera have them: in each stretch of time the one that came soonest.
///
/// What is ambiguous is refused and said so in `doubts`. An arm that stands still leaves only the stage and the host.
/// Source: Faris et al., arXiv:2403.10120, section IV, for events against the lift.
FoundAnchors clock_anchors(const AnchorInputs& inputs, const AnchorOptions& options = {});

}  // namespace tactile
