#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/capture/robot_bit.hpp"

namespace tactile::capture {

/// A list of runs to record, one after the other:
///
///   {"session": "monday", "objects": [{"name": "fan", "runs": 10}, …], "duration": 8, "start_on": "output_bit_register_64",
///    "stop_on": "actual_digital_output_bits:3"}
///
/// `runs` is the number of complete runs of the object in the end. Existing ones count, so that an interrupted session can be
/// resumed. An interrupted run does not count.
struct SessionPlan {
  struct Object {
    std::string name;
    int runs = 1;  ///< 1 to 99
  };
  std::string name;  ///< may be empty
  std::vector<Object> objects;
  std::optional<double> duration_s;  ///< of each run, > 0
  std::optional<RobotBit> start_on, stop_on;
};

/// @throws Error  if the file cannot be read, a member is missing, unknown or out of range, or an object is listed twice
SessionPlan read_session_plan(const std::filesystem::path& file);

/// Number of runs of the plan's `object` in `data` that are complete according to `run.json`, and ended as planned: not
/// interrupted, not because a source was lost and, if the plan has a duration, not because the source ended early.
int complete_runs(const std::filesystem::path& data, const SessionPlan& plan, const std::string& object);

}  // namespace tactile::capture
