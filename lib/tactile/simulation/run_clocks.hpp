#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tactile/core/clock_relation.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/simulation/drawn_value.hpp"

namespace tactile::simulation {

/// The distribution of the clocks of camera, robot, video and host.
struct ClockPhysics {
  Range drift_ppm{-100, 100};         ///< of robot and video against the camera
  Range before_camera_s{0.1, 1.5};    ///< time from the start of robot log and video to that of the camera
  Range robot_up_s{600, 200'000};     ///< uptime of the controller at the first run of a session
  double shared_session_share = 0.5;  ///< share of the objects whose runs are one session: camera and controller started once
  Range between_runs_s{20, 60};       ///< in a session, from the end of the longest possible run to the next start
};

template <class Fields>
void list_fields(Fields& fields, ClockPhysics& clocks) {
  fields("drift_ppm", clocks.drift_ppm, -10'000.0, 10'000.0);
  fields("before_camera_s", clocks.before_camera_s, 0.0, 60.0);
  fields("robot_up_s", clocks.robot_up_s, 0.0, 1e8);
  fields("shared_session_share", clocks.shared_session_share, 0.0, 1.0);
  fields("between_runs_s", clocks.between_runs_s, 0.0, 86'400.0);
}

/// The clocks of a run. They start at different times and have different rates.
struct RunClocks {
  std::string session;               ///< runs with the same session share their clocks
  std::int64_t camera_start_us = 0;  ///< the camera's first read-out
  ClockRelation robot, video;        ///< to the camera's; a video counts from 0
  std::int64_t host_from_camera_us = 0;
};

/// The clocks of run `run_number` (from 1) of `object`. For the given share of the ten objects (rounded down; for other objects,
/// by chance) all runs belong to one session and share one set of clocks. Every other run has its own clocks. The result does not
/// depend on which other runs are made.
/// @param longest_run_s  no run of the data set is longer
RunClocks clocks_of_run(const ClockPhysics& physics, std::uint64_t seed, std::string_view object, int run_number,
                        double longest_run_s);

/// The clocks of a later run of a session: camera, robot and video continue from the `first` run of the session. The camera's
/// first read-out is at `start`. Robot and video begin as long before it as in `drawn`.
RunClocks continued_clocks(const RunClocks& drawn, const RunClocks& first, CameraTime start);

}  // namespace tactile::simulation
