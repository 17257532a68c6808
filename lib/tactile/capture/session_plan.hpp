#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/capture/robot_bit.hpp"

namespace tactile {

/// A list of runs to record, one after the other:
///
///   {"session": "monday", "objects": [{"name": "fan", "runs": 10}, …], "duration": 8, "start_on": "output_bit_register_64",
///    "stop_on": "actual_digital_output_bits:3"}
///
/// `runs` is how many whole runs the object shall have in the end: those that are there already count, so a broken-off session is
/// taken up where it was left. A run that was broken off does not count.
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

/// @throws Error  if the file cannot be read, a member is missing, unknown or out of range, or an object stands there twice
SessionPlan read_session_plan(const std::filesystem::path& file);

/// Runs of the plan's `object` in `data` whose `run.json` says that they are complete, and that they ended as the plan has it:
/// not interrupted, nor because a source was gone, nor, where the plan has a duration, since the source ended ahead of it.
int complete_runs(const std::filesystem::path& data, const SessionPlan& plan, const std::string& object);

}  // namespace tactile
