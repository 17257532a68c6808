#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tactile/core/clock_relation.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/simulation/drawn_value.hpp"

namespace tactile {

/// What the clocks of camera, robot, video and host are drawn from.
struct ClockPhysics {
  Range drift_ppm{-100, 100};         ///< of robot and video against the camera
  Range before_camera_s{0.1, 1.5};    ///< robot log and video begin so much earlier than the camera
  Range robot_up_s{600, 200'000};     ///< since the controller started, at a session's first run
  double shared_session_share = 0.5;  ///< of the objects, whose runs share one start of camera and controller
  Range between_runs_s{20, 60};       ///< of one session, from when the longest run would have ended to the next one's start
};

template <class Fields>
void list_fields(Fields& fields, ClockPhysics& clocks) {
  fields("drift_ppm", clocks.drift_ppm, -10'000.0, 10'000.0);
  fields("before_camera_s", clocks.before_camera_s, 0.0, 60.0);
  fields("robot_up_s", clocks.robot_up_s, 0.0, 1e8);
  fields("shared_session_share", clocks.shared_session_share, 0.0, 1.0);
  fields("between_runs_s", clocks.between_runs_s, 0.0, 86'400.0);
}

/// A run's clocks, each started at another time and running at another rate.
struct RunClocks {
  std::string session;               ///< runs of one name share their clocks; it says nothing else
  std::int64_t camera_start_us = 0;  ///< the camera's first read-out
  ClockRelation robot, video;        ///< to the camera's; a video always counts from 0
  std::int64_t host_from_camera_us = 0;
};

/// The clocks of run `run_number` (from 1) of `object`. Of exactly the stated share of the ten objects (rounded down; for another
/// object, by chance) all runs belong to one session and follow each other on one set of clocks; every other run has its own.
/// Does not depend on which other runs are made.
/// @param longest_run_s  no run of the data set is longer
RunClocks clocks_of_run(const ClockPhysics& physics, std::uint64_t seed, std::string_view object, int run_number,
                        double longest_run_s);

/// The clocks of a later run of one session: camera, robot and video go on as they ran in the session's `first` run, the camera's
/// first read-out is at `start`, and robot and video begin as much earlier as they do in `drawn`.
RunClocks continued_clocks(const RunClocks& drawn, const RunClocks& first, CameraTime start);

}  // namespace tactile
