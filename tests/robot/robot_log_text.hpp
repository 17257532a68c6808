#pragma once

#include <string>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::test {

/// A header with the needed columns and what a test adds, parted by `separator`.
inline std::string header(const std::string& separator, const std::string& last = "") {
  std::string text = "timestamp";
  for (const char* name : {"actual_TCP_pose_", "actual_TCP_speed_"}) {
    for (int i = 0; i < 6; ++i) text += separator + name + std::to_string(i);
  }
  return text + (last.empty() ? "" : separator + last);
}

/// A row at `time` whose values are 0.5, 1.5, ... 11.5.
inline std::string row(const std::string& time, const std::string& separator, const std::string& last = "") {
  std::string text = time;
  for (int i = 0; i < 12; ++i) text += separator + std::to_string(i) + ".5";
  return text + (last.empty() ? "" : separator + last);
}

inline robot::RobotLogFile read_file(const std::string& text) {
  const TemporaryFolder folder;
  write_whole(folder / "robot.csv", text);
  return robot::read_robot_log(folder / "robot.csv");
}

inline robot::RobotLog read(const std::string& text) { return read_file(text).longest(); }

inline std::string complaint_about(const std::string& text) {
  try {
    read(text);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace tactile::test
