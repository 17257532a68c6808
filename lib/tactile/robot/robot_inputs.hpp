#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tactile::robot {

struct RobotInputsOptions {
  std::string host;
  std::uint16_t port = 30004;
  std::vector<int> bits;  ///< input bit registers, 64 to 127: those that RTDE clients may write
  std::chrono::milliseconds patience{5'000};
  /// Called from the thread that writes, when the robot is gone and when it is back.
  std::function<void(const std::string&)> log = {};
  std::function<void()> prepare = {};  ///< called first on that thread
};

struct RobotInputsState {
  bool connected = false;
  std::uint64_t writes = 0;
  std::uint64_t reconnects = 0;
  std::string controller;  ///< "5.11.6.1071234"
};

/// Writes bits of a UR controller by RTDE, in its input bit registers, from its own thread: the caller does not wait for the
/// robot. A lost connection is made again, however long that takes, and the bits are written again. All are low at first, and
/// again in the end. Source: UR's RTDE guide, protocol version 2.
class RobotInputs {
 public:
  /// Connects, agrees on the bits, and lowers them.
  /// @throws Error  if there is no controller, a bit is not from 64 to 127, unknown to it, or written by another client
  explicit RobotInputs(RobotInputsOptions options);
  ~RobotInputs();
  RobotInputs(const RobotInputs&) = delete;
  RobotInputs& operator=(const RobotInputs&) = delete;

  /// Sets the bits, in the order of the options; returns at once. `written` is called from the robot's thread once the robot has
  /// exactly these; not if others are set before.
  void set(std::uint64_t high, std::function<void()> written = {});

  RobotInputsState state() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::robot
