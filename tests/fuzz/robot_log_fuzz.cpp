#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/robot/motion_phases.hpp"
#include "tactile/robot/robot_log.hpp"

/// Whatever the bytes, they are a log whose times ascend and whose numbers are finite, with phases that end behind their start,
/// or an Error says why not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  const int file = memfd_create("robot", MFD_CLOEXEC);
  if (file < 0) return 0;
  if (write(file, data, size) == static_cast<ssize_t>(size)) {
    try {
      const RobotLogFile log_file = read_robot_log("/proc/self/fd/" + std::to_string(file));
      for (const RobotLog& log : log_file.pieces) {
        if (log.states.empty()) std::abort();
        for (std::size_t i = 1; i < log.states.size(); ++i) {
          if (log.states[i].t <= log.states[i - 1].t) std::abort();
        }
        for (const RobotState& state : log.states) {
          for (std::size_t k = 0; k < 6; ++k) {
            if (!std::isfinite(state.tcp_pose[k]) || !std::isfinite(state.tcp_speed[k])) std::abort();
          }
        }
        lost_packages(log);
        for (const OutputChange& change : log.output_changes) {
          if (change.at <= change.last_before || change.from == change.to) std::abort();
        }
        for (const MotionPhase& phase : motion_phases(log)) {
          if (phase.end < phase.start || !(phase.start_sigma_us > 0) || !(phase.end_sigma_us > 0)) std::abort();
        }
      }
    } catch (const Error&) {
    }
  }
  close(file);
  return 0;
}
