#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/alignment/activity.hpp"
#include "tactile/alignment/clock_fit.hpp"
#include "tactile/alignment/event_rate.hpp"
#include "tactile/alignment/motion_phases.hpp"
#include "tactile/core/doubt.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::alignment {

/// What is known of two clocks before any content is compared: camera_us - clock_us lies within `within` of `offset_us`.
struct CoarseOffset {
  std::int64_t offset_us = 0;
  microseconds within{};
};

/// When data of the camera arrived at the host.
struct CameraArrival {
  CameraTime camera{};
  HostTime host{};
};

/// One piece of the robot's log, and one recording.
struct AnchorInputs {
  const robot::RobotLog& robot;
  std::span<const MotionPhase> motions;  ///< of `robot`, by `motion_phases`
  const EventRate& rate;
  const QuietRate& quiet;
  std::span<const events::ImuSample> imu = {};  ///< none where the camera has no IMU
  /// run.json's `host_from_camera`, where it has it: with host times in the log they relate the two.
  std::span<const CameraArrival> host_from_camera = {};
  std::optional<CoarseOffset> coarse = {};  ///< nothing: all lags at which log and recording overlap are searched
};

struct AnchorOptions {
  microseconds grid{4'000};           ///< of the first search, over all lags; whole milliseconds
  double ambiguous_below = 1.2;       ///< a best match is refused if it is less than this many times as good as the second
  double least_likeness = 0.3;        ///< of the IMU: a worse match is refused; 1 is perfect
  double most_slack_m = 1e-3;         ///< of skin and object: the arm may move so far before anything shears
  microseconds stage_delay{350'000};  ///< from a stage's command to its contact, the middle of about 0.05 to 0.65 s
};

/// How well two signals of the run match at their best lag.
struct LagMatch {
  std::int64_t offset_us = 0;  ///< camera - clock
  double likeness = 0;         ///< 0 to 1
  double ratio = 0;            ///< to the second best, infinite if there is none
};

struct FoundAnchors {
  std::vector<ClockAnchor> anchors;     ///< by kind, then time
  std::vector<Doubt> doubts;            ///< what could not be used, and why
  std::vector<Doubt> contradictions;    ///< why log and recording may not belong together
  std::optional<LagMatch> imu, events;  ///< the first search, where it was possible
};

/// Both clocks in seconds from the log's first row and the recording's first bin, so that doubles hold them. A `shift` is camera
/// seconds - robot seconds.
struct ClockOrigins {
  RobotTime robot{};
  CameraTime camera{};
  std::int64_t apart_us = 0;  ///< camera - robot

  double seconds_of(RobotTime t) const { return 1e-6 * static_cast<double>(saturating_subtract(us_of(t), us_of(robot))); }
  double seconds_of(CameraTime t) const { return 1e-6 * static_cast<double>(between(camera, t).count()); }
  std::int64_t offset_us(double shift_s) const { return saturating_add(apart_us, std::llround(1e6 * shift_s)); }
  ClockAnchor anchor(double robot_s, double shift_s, double sigma_s, AnchorKind kind, double bias_s) const {
    const std::int64_t since_us = std::llround(1e6 * robot_s);
    return {.clock_us = saturating_add(us_of(robot), since_us),
            .camera = after(camera, microseconds{saturating_add(since_us, std::llround(1e6 * shift_s))}),
            .sigma_us = 1e6 * sigma_s,
            .kind = kind,
            .bias_us = 1e6 * bias_s};
  }
};

/// One search: what each witness reads, and what it adds to.
struct AnchorSearch {
  const AnchorInputs& inputs;
  const AnchorOptions& options;
  ClockOrigins origins;
  FoundAnchors found;
  std::vector<double> left_by_imu_s{};  ///< shifts that an ambiguous match of the IMU leaves; empty: any

  void add(double robot_s, double shift_s, double sigma_s, AnchorKind kind, double bias_s) {
    found.anchors.push_back(origins.anchor(robot_s, shift_s, sigma_s, kind, bias_s));
  }
  double grid_s() const { return 1e-6 * static_cast<double>(options.grid.count()); }
};

}  // namespace tactile::alignment
