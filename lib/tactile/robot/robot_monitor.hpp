#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/clock_pairs.hpp"

namespace tactile::robot {

struct RobotMonitorOptions {
  std::string host;
  std::uint16_t port = 30004;
  double frequency_hz = 0;  ///< 0: the controller's highest, 125 below version 5, else 500
  std::vector<std::string>
      extra_fields;  ///< RTDE output names beyond the usual ones; those that the controller lacks are left out
  std::vector<std::string> required_fields;  ///< of one number each; a controller that lacks one is refused
  std::chrono::milliseconds patience{5'000};
  /// Gets, from the monitor's own thread once it runs: "robot gone (…), trying again", "robot is back after 2.1 s", text messages
  /// of the robot. A repeated message is reported once, and its count after 10 s without it.
  std::function<void(const std::string&)> log;
};

/// The state of the robot's log.
struct RobotMonitorState {
  bool connected = false;
  double rate_hz = 0;         ///< over the last second
  std::uint64_t rows = 0;     ///< written to the present log
  std::uint64_t gaps = 0;     ///< in the present log: more than 1.5 periods between two packages, or a broken connection, or
                              ///< none at its start or end
  std::uint64_t missing = 0;  ///< packages that those gaps lack, by the controller's own clock if it did not restart; at the
                              ///< log's two ends by the host's, once the first package has arrived or the log has ended
  std::uint64_t reconnects = 0;
  std::uint64_t clock_starts = 1;  ///< of the controller's clock that the monitor has seen, in logs or between them
  /// How the controller's clock goes against the host's. Begins again with each log and with each restart of that clock.
  /// Nothing before the first package after that.
  std::optional<ClockOffset> clock;
  std::string controller;  ///< "3.15.8.106339"
  std::string error;       ///< why the log cannot continue (a full disk); empty if it can
};

/// Receives data of a UR controller by RTDE version 2 on its own thread, connects again whenever the connection is lost, and
/// writes logs. It stays connected between logs, so that the robot can start and stop them.
///
/// A log has the columns that `read_robot_log` reads, by RTDE's names, `timestamp` by the controller's clock [s], and last
/// `host_time_us`. Rows are written at once and synced every second: a kill loses at most a second. A lost connection is an empty
/// line in the log, which `read_robot_log` reads as a gap. Source: UR's RTDE guide, protocol version 2.
class RobotMonitor {
 public:
  /// Connects and agrees on the recipe.
  /// @throws Error  if there is no controller, it speaks no RTDE 2, or lacks a needed or required field
  explicit RobotMonitor(RobotMonitorOptions options);
  ~RobotMonitor();
  RobotMonitor(const RobotMonitor&) = delete;
  RobotMonitor& operator=(const RobotMonitor&) = delete;

  void start_log(const std::filesystem::path& file);  ///< @throws Error if it exists or cannot be made
  void stop_log();                                    ///< writes and syncs what is left. @throws Error if that failed

  RobotMonitorState state() const;
  /// The newest value of a field of any type; of a vector, by the name of its column. Nothing while disconnected.
  /// @throws Error if it was not requested, or the robot does not have it
  std::optional<double> newest(const std::string& field) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::robot
