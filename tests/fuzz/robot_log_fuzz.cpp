#include <cmath>

#include "abort_unless.hpp"
#include "bytes_as_file.hpp"
#include "tactile/core/error.hpp"
#include "tactile/robot/robot_log.hpp"

/// For any input, a log is read whose times ascend and whose numbers are finite, or there is an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  using test::abort_unless;
  const test::BytesAsFile file(data, size);
  try {
    // A log without header row begins with a number.
    const bool has_header = size == 0 || data[0] < '0' || data[0] > '9';
    const robot::RobotLogFile logs =
        robot::read_robot_log(file.path(), {.arm = {}, .columns = has_header ? "" : "timestamp,actual_q*6,-*3"});
    for (const robot::RobotLog& log : logs.pieces) {
      abort_unless(!log.states.empty());
      for (std::size_t i = 1; i < log.states.size(); ++i) abort_unless(log.states[i].t > log.states[i - 1].t);
      for (const robot::RobotState& state : log.states) {
        for (std::size_t k = 0; k < 6; ++k) abort_unless(std::isfinite(state.tcp_pose[k]) && std::isfinite(state.tcp_speed[k]));
      }
      robot::lost_packages(log);
      for (const robot::OutputChange& change : log.output_changes)
        abort_unless(change.at > change.last_before && change.from != change.to);
    }
  } catch (const Error&) {
  }
  return 0;
}
