#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/labels/activity.hpp"
#include "tactile/labels/clock_anchors.hpp"
#include "tactile/labels/event_rate.hpp"
#include "tactile/robot/motion_phases.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/video/motion_energy.hpp"

namespace tactile {

struct RunSignalsOptions {
  EventRateOptions rate{};
  ActivityOptions activity{};
  MotionEnergyOptions video{};
  microseconds shortest_gap{
      5'000};  ///< told if no pixel fires for so long, where the noise alone should have given 30 events at least
};

/// A stretch of camera time, half-open.
struct CameraSpan {
  CameraTime begin{}, end{};
};

/// A piece of the robot's log, which counts on one clock, and what the arm does in it.
struct RobotPiece {
  RobotLog log;
  std::vector<MotionPhase> phases;
};

/// What `tactile label` reads of a run, each on its own clock. Nothing is concluded from it yet.
struct RunSignals {
  RunFolder run;
  RunInfo info;  ///< of a folder without run.json: its names alone
  std::int32_t event_stream = 0;
  EventRate rate;
  QuietRate quiet;
  std::vector<Burst> bursts;
  std::vector<CameraSpan> gaps;  ///< in which no pixel fires, too long for chance, by time
  bool has_robot = false;        ///< there is a log, be it empty
  std::vector<RobotPiece> robot;
  RobotSpeedSource speed_from = RobotSpeedSource::actual_tcp_speed;  ///< of the log
  std::optional<ArmModel> arm;                                       ///< whose kinematics made the poses of joints, if any did
  std::vector<std::optional<CoarseOffset>> coarse_offsets;  ///< of each piece, where a host told when both devices' data came
  std::vector<CameraArrival> host_from_camera;              ///< of run.json: when the camera's data came to the host
  std::vector<ImuSample> imu;                               ///< by time; empty if the recording has none
  std::optional<MotionEnergy> video;
  std::vector<std::string> problems;  ///< of the files, in words: what a person should look at
  std::vector<std::string> remarks;   ///< what is missing or odd, but harms nothing
};

/// Reads events, IMU, robot log, film and run.json; never truth.json.
/// @throws Error  if the events or the robot log cannot be read; a film that cannot be is a problem
/// @throws OutsideFilm  if the film does not hold the region that it is asked for
RunSignals read_run_signals(const RunFolder& run, const RunSignalsOptions& options = {});

/// SHA-256 of each file that `read_run_signals` reads, by its name.
nlohmann::json hashes_of_inputs(const RunFolder& run);

}  // namespace tactile
