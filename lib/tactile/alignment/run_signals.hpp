#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/alignment/camera_span.hpp"
#include "tactile/alignment/event_rate.hpp"
#include "tactile/alignment/motion_energy.hpp"
#include "tactile/alignment/quiet_rate.hpp"
#include "tactile/core/doubt.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::alignment {

struct RunSignalsOptions {
  EventRateOptions rate{};
  MotionEnergyOptions video{};
  robot::RobotLogOptions robot{};
  /// Reported if no pixel fires for this long, where the noise alone gives at least 30 events on average.
  microseconds shortest_gap{5'000};
};

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

/// What `tactile label` reads of a run, each signal on its own clock.
struct RunSignals {
  RunFolder run;
  RunInfo info;  ///< of a folder without run.json: only its names
  std::int32_t event_stream = 0;
  EventRate rate;
  QuietRate quiet;
  std::vector<CameraSpan> gaps;  ///< in which no pixel fires, too long for chance, by time
  bool has_robot = false;        ///< there is a log, perhaps an empty one
  std::vector<robot::RobotLog>
      robot;  ///< its pieces on one clock each, but for those whose clock lies further from the camera's than int64 holds
  robot::RobotSpeedSource speed_from = robot::RobotSpeedSource::actual_tcp_speed;  ///< of the log
  std::optional<robot::ArmModel> arm;                       ///< whose kinematics gave poses from joints, if the log has no poses
  std::vector<std::optional<CoarseOffset>> coarse_offsets;  ///< of each piece, where the host times of both devices are known
  std::vector<CameraArrival> host_from_camera;              ///< of run.json: when the camera's data arrived at the host
  std::vector<events::ImuSample> imu;                       ///< by time; empty if the recording has none
  std::optional<MotionEnergy> video;
  std::vector<Doubt> problems;       ///< of the files: a person should check them
  std::vector<std::string> remarks;  ///< what is missing or unusual, but does no harm
};

/// Reads events, IMU, robot log, film and run.json; not truth.json.
/// @throws Error  if the events or the robot log cannot be read; a film that cannot be is a problem
/// @throws OutsideFilm  if the region is not inside the film
RunSignals read_run_signals(const RunFolder& run, const RunSignalsOptions& options = {});

/// Whether two clocks lie further apart than int64 holds.
bool are_too_far_apart(CameraTime camera, RobotTime robot);

/// When the camera's data arrived at the host, by `host_from_camera` of run.json; empty if it has none.
std::vector<CameraArrival> arrivals_in(const RunInfo& run);

/// SHA-256 of each file that `read_run_signals` reads, by its name.
nlohmann::json hashes_of_inputs(const RunFolder& run);

}  // namespace tactile::alignment
