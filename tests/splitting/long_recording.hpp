#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/core/touch.hpp"

namespace tactile::test {

/// A long recording of runs one after another, and what is true in it.
struct LongRecording {
  std::filesystem::path folder;          ///< with events.aedat4, robot.csv and run.json
  std::vector<CameraTime> run_begins{};  ///< the first event of each run
  std::vector<CameraTime> run_ends{};    ///< its last
  std::vector<TouchInterval> touches{};  ///< the labelled presses and slips of all runs, by time
};

/// Joins simulated runs in one recording on one camera clock, without a pause. The robot's log is on one clock too, which is 5 s
/// ahead of the camera's. Between two runs the arm rests where it is.
LongRecording join_runs(const std::vector<RunFolder>& runs, const std::filesystem::path& folder);

}  // namespace tactile::test
